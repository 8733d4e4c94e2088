#include "algorithms/io/png_encoder.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace gaitcam {
namespace {

/// A ramp with noise: rows resemble each other, no two are equal.
cv::Mat Picture(int type, cv::Size size) {
  cv::RNG random(7);
  cv::Mat picture(size, type);
  random.fill(picture, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  cv::Mat smooth;
  cv::reduce(picture, smooth, 0, cv::REDUCE_MAX);
  for (int row = 0; row < size.height; row += 2) smooth.copyTo(picture.row(row));
  return picture;
}

const std::vector<int> kTypes = {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3};

TEST(PngEncoder, AnotherLibraryReadsTheSamePixels) {
  for (const int type : kTypes) {
    for (const cv::Size size : {cv::Size(320, 240), cv::Size(1, 1), cv::Size(7, 3), cv::Size(1, 50)}) {
      const cv::Mat picture = Picture(type, size);
      for (const int compression : {0, 1, 6, 9}) {
        const cv::Mat read = cv::imdecode(EncodePng(picture, compression), cv::IMREAD_UNCHANGED);
        ASSERT_EQ(read.type(), type);
        ASSERT_EQ(read.size(), size);
        EXPECT_EQ(cv::norm(read, picture, cv::NORM_INF), 0) << type << " " << size << " " << compression;
      }
    }
  }
}

TEST(PngEncoder, RowsMayLieApart) {
  const cv::Mat whole = Picture(CV_8UC3, {40, 30}), part = whole(cv::Rect(3, 4, 20, 10));
  EXPECT_EQ(EncodePng(part, 1), EncodePng(part.clone(), 1));
}

TEST(PngEncoder, MoreCompressionGivesSmallerFiles) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    cv::Mat picture;
    cv::GaussianBlur(Picture(type, {320, 240}), picture, {}, 4);  // noise alone cannot be compressed
    const size_t none = EncodePng(picture, 0).size(), fast = EncodePng(picture, 1).size();
    EXPECT_LT(fast, none) << type;
    EXPECT_LT(EncodePng(picture, 9).size(), fast) << type;
  }
}

TEST(PngEncoder, TheSameImageGivesTheSameBytes) {
  EXPECT_EQ(EncodePng(Picture(CV_16UC3, {64, 48}), 1), EncodePng(Picture(CV_16UC3, {64, 48}), 1));
}

}  // namespace
}  // namespace gaitcam
