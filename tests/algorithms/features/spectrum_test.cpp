#include "algorithms/features/spectrum.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

/// Part of an image away from its border, where margins do not matter.
cv::Mat Middle(const cv::Mat& image, int border) {
  return image(cv::Rect(border, border, image.cols - 2 * border, image.rows - 2 * border));
}

TEST(Spectrum, AFilterOfOneGivesTheImageBack) {
  for (const cv::Size size : {cv::Size(101, 67), cv::Size(160, 120), cv::Size(1, 1)}) {
    const cv::Mat image = Values(RandomPicture(size, 1));
    EXPECT_LT(cv::norm(Spectrum(image, 20).Through(GaussianTransfer(0, 0, 0)), image, cv::NORM_INF), 1e-5) << size;
  }
}

TEST(Spectrum, AGaussianIsWhatSmoothingInSpaceGives) {
  const cv::Mat image = Values(RandomPicture({160, 120}, 2));
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, cv::Size(31, 31), 3);
  const cv::Mat seen = Spectrum(image, 48).Through(GaussianTransfer(3, 3, 0.7));
  EXPECT_LT(cv::norm(Middle(seen, 16), Middle(smooth, 16), cv::NORM_INF), 1e-3);
}

TEST(Spectrum, CoarserOctavesSampleTheSameImage) {
  const cv::Mat image = Values(RandomPicture({161, 122}, 3));
  const Spectrum spectrum(image, 48);
  const GaussianTransfer gaussian(6, 9, 0.4);  // too smooth for anything to be lost at a quarter of the resolution
  const cv::Mat fine = spectrum.Through(gaussian), coarse = spectrum.Through(gaussian, 2);
  ASSERT_EQ(coarse.size(), cv::Size(41, 31));
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x) EXPECT_NEAR(coarse.at<float>(y, x), fine.at<float>(4 * y, 4 * x), 1e-3);
}

TEST(Spectrum, ALineTransferIsALineBlur) {
  const LineBlur blur{14, 0.6};
  const cv::Mat picture = RandomPicture({200, 160}, 4);
  const cv::Mat blurred = Values(BlurAndCrop(picture, blur, 40));
  const cv::Mat seen = Spectrum(Values(picture), 48).Through(LineTransfer(blur));
  // Whole grey levels, and interpolation in the reference.
  EXPECT_LT(cv::norm(Middle(seen, 40), blurred, cv::NORM_L2) / std::sqrt(double(blurred.total())), 0.006);
}

}  // namespace
}  // namespace gaitcam
