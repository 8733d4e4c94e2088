#include "algorithms/io/image_file.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kVectorScale = 64, kVectorOffset = 32768;  // KITTI's development kit for optical flow

void WriteEncoded(const std::filesystem::path& file, const char* extension, const cv::Mat& image,
                  const std::vector<int>& parameters) {
  std::vector<uchar> bytes;
  GAITCAM_ASSERT(!image.empty() && cv::imencode(extension, image, bytes, parameters));
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  stream.flush();
  if (!stream) throw MissingResource(file.string() + ": cannot write this file");
}

[[noreturn]] void Fail(const std::filesystem::path& file, const std::string& message, const std::string& listed_at) {
  throw BadInput(file.string() + ": " + message + (listed_at.empty() ? "" : " (listed at " + listed_at + ")"));
}

cv::Mat ReadEncoded(const std::filesystem::path& file, const std::string& listed_at) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) Fail(file, "cannot read this file", listed_at);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  cv::Mat image;
  try {
    if (!bytes.empty()) image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) Fail(file, "is not an image that can be decoded", listed_at);
  return image;
}

/// OpenCV tries every row filter of PNG once a level is named; unnamed it takes the fastest filter, level and strategy,
/// which halves the time at the same size.
std::vector<int> Compression(int level) {
  if (level == 1) return {};
  return {cv::IMWRITE_PNG_COMPRESSION, level};
}

}  // namespace

void WritePng(const std::filesystem::path& file, const cv::Mat& image, int compression) {
  WriteEncoded(file, ".png", image, Compression(compression));
}

bool WriteDepthPng(const std::filesystem::path& file, const cv::Mat& depth, int compression) {
  GAITCAM_ASSERT(depth.type() == CV_32FC1);
  cv::Mat coded(depth.size(), CV_16UC1);
  bool exact = true;
  for (int row = 0; row < depth.rows; ++row) {
    const float* from = depth.ptr<float>(row);
    uint16_t* to = coded.ptr<uint16_t>(row);
    for (int col = 0; col < depth.cols; ++col) {
      const double units = std::round(double(from[col]) * kDepthUnitsPerMetre);
      to[col] = units >= 1 && units <= std::numeric_limits<uint16_t>::max() ? uint16_t(units) : uint16_t(0);
      exact = exact && float(to[col] / kDepthUnitsPerMetre) == from[col];
    }
  }
  WritePng(file, coded, compression);
  return exact;
}

void WriteDepthTiff(const std::filesystem::path& file, const cv::Mat& depth) {
  GAITCAM_ASSERT(depth.type() == CV_32FC1);
  WriteEncoded(file, ".tiff", depth, {});
}

void WriteVectorsPng(const std::filesystem::path& file, const cv::Mat& vectors, int compression) {
  GAITCAM_ASSERT(vectors.type() == CV_32FC2);
  cv::Mat coded(vectors.size(), CV_16UC3, cv::Scalar::all(0));
  constexpr double kMax = std::numeric_limits<uint16_t>::max();
  for (int row = 0; row < vectors.rows; ++row) {
    for (int col = 0; col < vectors.cols; ++col) {
      const auto& v = vectors.at<cv::Vec2f>(row, col);
      const double x = std::round(v[0] * kVectorScale + kVectorOffset);
      const double y = std::round(v[1] * kVectorScale + kVectorOffset);
      if (!(x >= 0 && x <= kMax && y >= 0 && y <= kMax)) continue;
      coded.at<cv::Vec3w>(row, col) = {1, uint16_t(y), uint16_t(x)};  // blue, green, red
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
