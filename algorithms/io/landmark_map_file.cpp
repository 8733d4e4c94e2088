#include "algorithms/io/landmark_map_file.h"

#include <bit>
#include <set>
#include <string>
#include <string_view>

#include "algorithms/core/errors.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

static_assert(std::endian::native == std::endian::little);  // floats are written as they lie in memory

constexpr size_t kCovariance = 4, kDescriptor = 10;  // columns

std::string DescriptorText(const cv::Mat& descriptor) {
  if (descriptor.empty()) return {};
  GAITCAM_ASSERT(descriptor.rows == 1 && (descriptor.type() == CV_8UC1 || descriptor.type() == CV_32FC1));
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = descriptor.type() == CV_8UC1 ? "u8:" : "f32:";
  const uchar* bytes = descriptor.ptr();
  for (size_t i = 0; i < descriptor.elemSize() * size_t(descriptor.cols); ++i) {
    text += kDigits[bytes[i] >> 4];
    text += kDigits[bytes[i] & 15];
  }
  return text;
}

int Digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

cv::Mat ReadDescriptor(const TextTable& table) {
  const std::string_view text = table.Text(kDescriptor, "a descriptor, or empty");
  if (text.empty()) return {};
  const bool floats = text.starts_with("f32:");
  if (!floats && !text.starts_with("u8:")) table.Fail("a descriptor begins with u8: or f32:");
  const std::string_view digits = text.substr(text.find(':') + 1);
  const size_t size = floats ? 4 : 1;
  if (digits.empty() || digits.size() % (2 * size) != 0) {
    table.Fail("a descriptor of " + std::to_string(digits.size()) + " hexadecimal digits; expected a multiple of " +
               std::to_string(2 * size));
  }
  cv::Mat descriptor(1, int(digits.size() / (2 * size)), floats ? CV_32FC1 : CV_8UC1);
  for (size_t i = 0; i < digits.size(); i += 2) {
    const int high = Digit(digits[i]), low = Digit(digits[i + 1]);
    if (high < 0 || low < 0) table.Fail("a descriptor has a character that is no hexadecimal digit (0-9, a-f)");
    descriptor.ptr()[i / 2] = uchar(16 * high + low);
  }
  return descriptor;
}

std::optional<Eigen::Matrix3d> ReadCovariance(const TextTable& table) {
  if (table.Text(kCovariance, "a covariance, or empty").empty()) return std::nullopt;
  Eigen::Matrix3d covariance;
  size_t column = kCovariance;
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) {
      covariance(row, col) = covariance(col, row) = table.Number(column++, "a covariance");
    }
  }
  return covariance;
}

}  // namespace

void WriteLandmarkMap(const std::filesystem::path& file, const LandmarkMap& map) {
  std::string text = "#id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,descriptor\n";
  for (const MapPoint& point : map.points) {
    text += std::to_string(point.id);
    for (const double coordinate : point.p_W) text += "," + ExactText(coordinate);
    for (int row = 0; row < 3; ++row) {
      for (int col = row; col < 3; ++col) {
        text += "," + (point.covariance ? ExactText((*point.covariance)(row, col)) : std::string());
      }
    }
    text += "," + DescriptorText(point.descriptor) + "\n";
  }
  WriteWholeFile(file, text);
}

LandmarkMap ReadLandmarkMap(const std::filesystem::path& file) {
  LandmarkMap map;
  std::set<int64_t> ids;
  TextTable table(file, ',');
  while (table.Next()) {
    MapPoint& point = map.points.emplace_back();
    point.id = table.Integer(0, "a landmark's id");
    if (!ids.insert(point.id).second) table.Fail("the id " + std::to_string(point.id) + " stands twice");
    for (size_t i = 0; i < 3; ++i) point.p_W[long(i)] = table.Number(1 + i, "a coordinate");
    point.covariance = ReadCovariance(table);
    point.descriptor = ReadDescriptor(table);
  }
  return map;
}

}  // namespace gaitcam
