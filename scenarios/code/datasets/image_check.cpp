#include "scenarios/code/datasets/image_check.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// Decoders accept truncated PNG files, so the chunks are followed to the end.
std::string FaultOfPng(const std::string& bytes) {
  const std::string signature = "\x89PNG\r\n\x1a\n";
  if (!bytes.starts_with(signature)) return "is no PNG";
  for (size_t at = signature.size(); at + 12 <= bytes.size();) {
    const auto byte = [&](size_t i) { return size_t(static_cast<unsigned char>(bytes[at + i])); };
    const size_t length = byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
    if (bytes.compare(at + 4, 4, "IEND") == 0) return "";
    at += 12 + length;
  }
  return "is cut off";
}

/// FNV-1a.
uint64_t HashOfPixels(const cv::Mat& image) {
  uint64_t hash = 14695981039346656037ull;
  for (int row = 0; row < image.rows; ++row) {
    const uchar* bytes = image.ptr(row);
    for (size_t i = 0; i < size_t(image.cols) * image.elemSize(); ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  }
  return hash | 1;
}

std::string FaultOfPixels(const cv::Mat& image, ImageKind kind, const CameraModel& camera) {
  if (image.empty()) return "cannot be decoded";
  const int type = image.type();
  if (kind == ImageKind::kPicture && type != CV_8UC1 && type != CV_8UC3) return "is no image of 8 bits per channel";
  if (kind == ImageKind::kDepth && type != CV_16UC1) return "is no depth image of 16 bits and one channel";
  if (kind == ImageKind::kVectors && type != CV_16UC3) return "is no image of vectors (16 bits, three channels)";
  if (camera.width_px > 0 && (image.cols != camera.width_px || image.rows != camera.height_px)) {
    return fmt::format("has {} x {} pixels, the calibration says {} x {}", image.cols, image.rows, camera.width_px,
                       camera.height_px);
  }
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  if (kind == ImageKind::kPicture && deviation[0] + deviation[1] + deviation[2] == 0) return "is all of one colour";
  return "";
}

void CheckUnlisted(const fs::path& folder, const fs::path& table, const std::set<fs::path>& listed,
                   Problems& problems) {
  if (!fs::is_directory(folder)) return;
  std::set<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (listed.count(entry.path()) == 0) others.insert(entry.path());
  }
  for (const fs::path& file : others) problems.push_back({file, 0, "is not listed in " + table.string()});
}

}  // namespace

std::string FaultOfImage(const fs::path& file, ImageKind kind, const CameraModel& camera, uint64_t* content) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || fs::is_directory(file)) return "there is no such file";
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (bytes.empty()) return "is empty";
  if (file.extension() == ".png") {
    const std::string fault = FaultOfPng(bytes);
    if (!fault.empty()) return fault;
  }
  cv::Mat image;
  try {
    image = cv::imdecode(cv::Mat(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();
  }
  const std::string fault = FaultOfPixels(image, kind, camera);
  if (content != nullptr && fault.empty()) *content = HashOfPixels(image);
  return fault;
}

std::vector<CheckedImage> CheckImages(const fs::path& root, const std::string& name, bool tum, ImageKind kind,
                                      const CameraModel& camera, bool by_ours, Problems& problems) {
  const fs::path folder = tum ? root : root / name / "data";
  CheckedTable table(tum ? root / (name + ".txt") : root / name / "data.csv", tum ? ' ' : ',', 2, problems);
  const std::vector<std::optional<int64_t>> stamps = table.Stamps(tum);
  std::vector<CheckedImage> images;
  std::set<fs::path> listed;
  for (size_t row = 0; row < table.size(); ++row) {
    const fs::path file = folder / table.Text(row, 1);
    if (!listed.insert(file).second) table.Fail(row, table.Text(row, 1) + " is listed twice");
    CheckedImage image{stamps[row].value_or(0), table.line(row), file, 0};
    const std::string fault = FaultOfImage(file, kind, camera, &image.content);
    if (!fault.empty()) table.Fail(row, file.string() + ": " + fault);
    if (!stamps[row]) continue;
    const std::string named = tum ? SecondsText(*stamps[row]) : std::to_string(*stamps[row]);
    if (by_ours && file.stem() != named)
      table.Fail(row, fmt::format("{} is not the image of its time; expected {}.png", table.Text(row, 1), named));
    images.push_back(image);
  }
  if (table.was_read() && table.size() == 0) table.FailWhole("lists no image");
  CheckUnlisted(tum ? root / name : folder, table.file(), listed, problems);
  return images;
}

}  // namespace gaitcam
