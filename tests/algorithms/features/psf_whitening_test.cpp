#include "algorithms/features/psf_whitening.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {
namespace {

using psf_test::Photograph;

/// Independent grey levels: what the method assumes of an image.
cv::Mat Speckle(int width, int height) {
  RandomStream random(3, "speckle");
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at<uchar>(y, x) = uchar(random.Index(256));
  }
  return image;
}

TEST(WhiteningPsf, FindsTheBlurOfAnImageWithoutStructure) {
  // Bins are 5 degrees wide, so the interpolated direction is good to about a tenth of that.
  for (const LineBlur truth : {LineBlur{12, 0}, LineBlur{20, 45 * kRadPerDeg}, LineBlur{16, 110 * kRadPerDeg}}) {
    const BlurEstimate e = WhiteningPsf().EstimateWhole(BlurPhotograph(Speckle(700, 540), truth, 0, 1));
    EXPECT_LT(e.blur.DirectionError(truth), 1.5 * kRadPerDeg) << truth.extent_px;
    EXPECT_NEAR(e.blur.extent_px, truth.extent_px, 1);
    EXPECT_TRUE(e.blurred);
    EXPECT_GT(e.confidence, 0.2);  // 0.25 to 0.8: slanted lines are interpolated, which correlates neighbours
  }
}

TEST(WhiteningPsf, MeasuresTheExtentAlongAKnownDirectionOfAPhotograph) {
  for (const double extent : {15.0, 20.0, 30.0}) {
    const LineBlur truth{extent, 0.5};
    const cv::Mat image = BlurPhotograph(Photograph("graf1.png"), truth, 0, 1);
    EXPECT_NEAR(WhiteningPsf().EstimateExtent(image, {}, truth.direction_rad).blur.extent_px, extent, 1.5);
  }
}

TEST(WhiteningPsf, DerivativesAreLeastAlongTheBlur) {
  const LineBlur truth{20, 60 * kRadPerDeg};
  cv::Mat values;
  BlurPhotograph(Speckle(500, 400), truth, 0, 1).convertTo(values, CV_32F);
  const std::vector<double> bins = DirectionalDerivatives(values, {{0, 0}, values.size()}, 36, 5);
  ASSERT_EQ(bins.size(), 36u);
  EXPECT_EQ(std::min_element(bins.begin(), bins.end()) - bins.begin(), 12);  // 60 degrees
}

TEST(WhiteningPsf, LeastDirectionLiesOnTheParabolaAndWrapsAround) {
  // A parabola with its least value at bin -0.25 of 4: 180 - 0.25 * 45 degrees.
  std::vector<double> bins;
  for (const double b : {0.0, 1.0, 2.0, -1.0}) bins.push_back((b + 0.25) * (b + 0.25));
  EXPECT_NEAR(LeastDirection(bins), (180 - 0.25 * 45) * kRadPerDeg, 1e-12);
}

TEST(WhiteningPsf, LooksAtMaskedPixelsAlone) {
  const cv::Mat speckle = Speckle(700, 400);
  cv::Mat both = BlurPhotograph(speckle, {25, 0}, 0, 1, false, {640, 360});
  const cv::Rect right(320, 0, 320, both.rows);
  BlurPhotograph(speckle, {12, 0}, 0, 1, false, {640, 360})(right).copyTo(both(right));
  cv::Mat mask(both.size(), CV_8UC1, cv::Scalar(0));
  mask(right).setTo(255);
  EXPECT_NEAR(WhiteningPsf().EstimateExtent(both, mask, 0).blur.extent_px, 12, 0.7);
  EXPECT_NEAR(WhiteningPsf().EstimateExtent(both, ~mask, 0).blur.extent_px, 25, 0.7);
}

TEST(WhiteningPsf, SaysNothingOfEmptyImages) {
  const BlurEstimate e = WhiteningPsf().EstimateWhole(cv::Mat(100, 100, CV_8UC1, cv::Scalar(50)));
  EXPECT_FALSE(e.blurred);
  EXPECT_EQ(e.confidence, 0);
}

TEST(WhiteningPsf, RefusesImpossibleOptions) {
  WhiteningOptions options;
  options.directions = 1;
  EXPECT_THROW(WhiteningPsf{options}, BadOption);
}

}  // namespace
}  // namespace gaitcam
