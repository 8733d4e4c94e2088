#include "algorithms/io/image_file.h"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/png_encoder.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

constexpr double kVectorScale = 64, kVectorOffset = 32768;  // KITTI's development kit for optical flow

void WriteBytes(const std::filesystem::path& file, const std::vector<uint8_t>& bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  stream.flush();
  if (!stream) FailToWrite(file, errno);
}

[[noreturn]] void Fail(const std::filesystem::path& file, const std::string& message, const std::string& listed_at) {
  throw BadInput(file.string() + ": " + message + (listed_at.empty() ? "" : " (listed at " + listed_at + ")"));
}

cv::Mat ReadEncoded(const std::filesystem::path& file, const std::string& listed_at) {
  cv::Mat image;
  try {
    const std::string bytes = FileContent(file);
    if (!bytes.empty()) image = cv::imdecode(cv::_InputArray(bytes.data(), int(bytes.size())), cv::IMREAD_UNCHANGED);
  } catch (const BadInput&) {
    Fail(file, "cannot read this file", listed_at);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) Fail(file, "is not an image that can be decoded", listed_at);
  return image;
}

/// std::round without a call of a function for each number: 32-bit floats, scaled, leave a double room to add a half.
/// @returns whether it fits.
bool Round16(double value, uint16_t& rounded) {
  if (!(value > -0.5 && value < std::numeric_limits<uint16_t>::max() + 0.5)) return false;
  rounded = uint16_t(value + 0.5);
  return true;
}

}  // namespace

void WritePng(const std::filesystem::path& file, const cv::Mat& image, int compression) {
  WriteBytes(file, EncodePng(image, compression));
}

bool WriteDepthPng(const std::filesystem::path& file, const cv::Mat& depth, int compression) {
  GAITCAM_ASSERT(depth.type() == CV_32FC1);
  cv::Mat coded(depth.size(), CV_16UC1);
  bool exact = true;
  for (int row = 0; row < depth.rows; ++row) {
    const float* from = depth.ptr<float>(row);
    uint16_t* to = coded.ptr<uint16_t>(row);
    for (int col = 0; col < depth.cols; ++col) {
      if (!Round16(double(from[col]) * kDepthUnitsPerMetre, to[col])) to[col] = 0;
      exact = exact && float(to[col] / kDepthUnitsPerMetre) == from[col];
    }
  }
  WritePng(file, coded, compression);
  return exact;
}

void WriteDepthTiff(const std::filesystem::path& file, const cv::Mat& depth) {
  GAITCAM_ASSERT(depth.type() == CV_32FC1);
  std::vector<uint8_t> bytes;
  GAITCAM_ASSERT(cv::imencode(".tiff", depth, bytes));
  WriteBytes(file, bytes);
}

void WriteVectorsPng(const std::filesystem::path& file, const cv::Mat& vectors, int compression) {
  GAITCAM_ASSERT(vectors.type() == CV_32FC2);
  cv::Mat coded(vectors.size(), CV_16UC3, cv::Scalar::all(0));
  for (int row = 0; row < vectors.rows; ++row) {
    const auto* from = vectors.ptr<cv::Vec2f>(row);
    auto* to = coded.ptr<cv::Vec3w>(row);
    for (int col = 0; col < vectors.cols; ++col) {
      uint16_t x = 0, y = 0;
      if (!Round16(from[col][0] * kVectorScale + kVectorOffset, x)) continue;
      if (!Round16(from[col][1] * kVectorScale + kVectorOffset, y)) continue;
      to[col] = {1, y, x};  // blue, green, red
    }
  }
  WritePng(file, coded, compression);
}

cv::Mat ReadImage(const std::filesystem::path& file, const std::string& listed_at) {
  cv::Mat image = ReadEncoded(file, listed_at);
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3) {
    Fail(file, "is not an image of 8 bits and one or three channels", listed_at);
  }
  return image;
}

cv::Mat ReadDepthPng(const std::filesystem::path& file, const std::string& listed_at) {
  const cv::Mat coded = ReadEncoded(file, listed_at);
  if (coded.type() != CV_16UC1) Fail(file, "is not a depth image of 16 bits and one channel", listed_at);
  cv::Mat depth(coded.size(), CV_32FC1);
  for (int row = 0; row < depth.rows; ++row) {
    for (int col = 0; col < depth.cols; ++col) {
      depth.at<float>(row, col) = float(coded.at<uint16_t>(row, col) / kDepthUnitsPerMetre);
    }
  }
  return depth;
}

cv::Mat ReadDepthTiff(const std::filesystem::path& file, const std::string& listed_at) {
  cv::Mat depth = ReadEncoded(file, listed_at);
  if (depth.type() != CV_32FC1) Fail(file, "is not a depth image of 32-bit floats", listed_at);
  return depth;
}

cv::Mat ReadVectorsPng(const std::filesystem::path& file, const std::string& listed_at) {
  const cv::Mat coded = ReadEncoded(file, listed_at);
  if (coded.type() != CV_16UC3) Fail(file, "is not an image of vectors (16 bits, three channels)", listed_at);
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  cv::Mat vectors(coded.size(), CV_32FC2, cv::Scalar::all(kUnknown));
  for (int row = 0; row < coded.rows; ++row) {
    for (int col = 0; col < coded.cols; ++col) {
      const auto& c = coded.at<cv::Vec3w>(row, col);
      if (c[0] == 0) continue;
      vectors.at<cv::Vec2f>(row, col) = {float((c[2] - kVectorOffset) / kVectorScale),
                                         float((c[1] - kVectorOffset) / kVectorScale)};
    }
  }
  return vectors;
}

}  // namespace gaitcam
