#include "algorithms/features/psf_spectral.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {
namespace {

using psf_test::Photograph;
using psf_test::PhotographNames;

struct Count {
  int all = 0, good = 0, close = 0, blurred = 0;
};

/// Good: 1 degree and 0.5 px; close: 5 degrees and 2 px.
Count EstimateAll(const std::vector<double>& extents, double noise, bool linear_light, cv::Size size = {640, 480},
                  const SpectralOptions& options = {}) {
  const SpectralPsf psf(options);
  Count count;
  RandomStream random(7, "directions");
  for (const std::string& name : PhotographNames()) {
    const cv::Mat photograph = Photograph(name);
    for (const double extent : extents) {
      const LineBlur truth{extent, random.Uniform(0, M_PI)};
      const BlurEstimate e = psf.EstimateWhole(BlurPhotograph(photograph, truth, noise, 1, linear_light, size));
      const double direction = e.blur.DirectionError(truth), length = std::abs(e.blur.extent_px - extent);
      ++count.all;
      count.good += direction <= kRadPerDeg && length <= 0.5;
      count.close += direction <= 5 * kRadPerDeg && length <= 2;
      count.blurred += e.blurred;
    }
  }
  return count;
}

TEST(SpectralPsf, FindsDirectionAndExtentOfLineBlurInPhotographs) {
  const Count count = EstimateAll({10, 15, 20, 30, 40}, 0, false);
  EXPECT_GE(count.good, 0.95 * count.all);
  EXPECT_GE(count.blurred, 0.95 * count.all);
}

TEST(SpectralPsf, BearsTheNoiseOfAnOrdinaryCamera) {
  const Count count = EstimateAll({10, 20, 40}, 2, false);
  EXPECT_GE(count.good, 0.9 * count.all);
  EXPECT_GE(count.close, 0.95 * count.all);
}

TEST(SpectralPsf, StaysCloseInStrongNoise) {
  const Count count = EstimateAll({10, 20, 40}, 5, false);
  EXPECT_GE(count.close, 0.95 * count.all);
}

TEST(SpectralPsf, HoldsForLightAddedBeforeGamma) {
  // The zeros are those of the linear image; gamma fills them a little, but does not move them.
  const Count count = EstimateAll({10, 20, 30}, 1, true);
  EXPECT_GE(count.close, 0.95 * count.all);
}

TEST(SpectralPsf, IsRightMoreOftenInTheValuesThatTheBlurAveraged) {
  SpectralOptions of_light;
  of_light.light = true;
  EXPECT_GT(EstimateAll({6, 10}, 0, true, {640, 480}, of_light).good, EstimateAll({6, 10}, 0, true).good);
  EXPECT_LT(EstimateAll({6, 10}, 0, false, {640, 480}, of_light).good, EstimateAll({6, 10}, 0, false).good);
}

TEST(SpectralPsf, LeavesSharpImagesAlone) {
  for (const double noise : {0.0, 2.0, 5.0}) {
    EXPECT_EQ(EstimateAll({0, 1, 2, 3}, noise, false).blurred, 0) << noise;
  }
}

TEST(SpectralPsf, WorksInAQuarterOfTheImage) {
  const Count count = EstimateAll({12, 20}, 1, false, {320, 240});
  EXPECT_GE(count.close, 0.9 * count.all);
}

TEST(SpectralPsf, LooksAtItsRegionAlone) {
  const cv::Mat photograph = Photograph("graf1.png");
  const LineBlur left{24, 0.4}, right{15, 1.9};
  cv::Mat both = BlurPhotograph(photograph, left, 0, 1);
  const cv::Rect half(320, 0, 320, 480);
  BlurPhotograph(photograph, right, 0, 1)(half).copyTo(both(half));
  const SpectralPsf psf;
  const BlurEstimate a = psf.Estimate(both, {0, 0, 320, 480}), b = psf.Estimate(both, half);
  EXPECT_NEAR(a.blur.extent_px, left.extent_px, 1);
  EXPECT_NEAR(b.blur.extent_px, right.extent_px, 1);
  EXPECT_LT(a.blur.DirectionError(left), 2 * kRadPerDeg);
  EXPECT_LT(b.blur.DirectionError(right), 2 * kRadPerDeg);
}

TEST(SpectralPsf, SaysNothingOfEmptyImages) {
  const SpectralPsf psf;
  for (const int grey : {0, 128, 255}) {
    const BlurEstimate e = psf.EstimateWhole(cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey)));
    EXPECT_FALSE(e.blurred);
    EXPECT_EQ(e.confidence, 0);
  }
  EXPECT_FALSE(psf.EstimateWhole(cv::Mat(20, 20, CV_8UC1, cv::Scalar(9))).blurred);
}

TEST(SpectralPsf, GivesTheSameBitsWhateverTheNumberOfThreads) {
  const cv::Mat image = BlurPhotograph(Photograph("home.jpg"), {17, 1.1}, 2, 1);
  const int before = cv::getNumThreads();
  std::vector<BlurEstimate> estimates;
  for (const int threads : {1, 2, 4}) {
    cv::setNumThreads(threads);
    estimates.push_back(SpectralPsf().EstimateWhole(image));
  }
  cv::setNumThreads(before);
  for (const BlurEstimate& e : estimates) {
    EXPECT_EQ(e.blur.extent_px, estimates[0].blur.extent_px);
    EXPECT_EQ(e.blur.direction_rad, estimates[0].blur.direction_rad);
    EXPECT_EQ(e.confidence, estimates[0].confidence);
  }
}

TEST(SpectralPsf, RefusesImpossibleOptions) {
  SpectralOptions options;
  options.window_px = 100;
  EXPECT_THROW(SpectralPsf{options}, BadOption);
  options = {};
  options.high_frequency = 0.7;
  EXPECT_THROW(SpectralPsf{options}, BadOption);
}

}  // namespace
}  // namespace gaitcam
