#include "algorithms/features/scale_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

TEST(ScaleSpace, LevelsAreThoseOfTheThesis) {
  const std::vector<double> scales = LevelScales({});
  const std::vector<double> thesis = {1.6, 2.0159, 2.5398, 3.2, 4.0317};
  ASSERT_EQ(scales.size(), thesis.size());
  for (size_t i = 0; i < thesis.size(); ++i) EXPECT_NEAR(scales[i], thesis[i], 1e-4);
}

TEST(ScaleSpace, APointSpreadsToAGaussianOfEachScale) {
  cv::Mat image = cv::Mat::zeros(129, 129, CV_32FC1);
  image.at<float>(64, 64) = 1;
  ScaleSpaceOptions options;
  options.camera_sigma = 0;
  options.octaves = 2;
  for (const ScaleOctave& octave : BuildScaleSpace(image, options))
    for (const ScaleLevel& level : octave.levels) {
      double sum = 0, squares = 0;
      for (int y = 0; y < level.light.rows; ++y)
        for (int x = 0; x < level.light.cols; ++x) {
          const double u = octave.pitch_px * x - 64, v = level.light.at<float>(y, x);
          sum += v;
          squares += v * u * u;
        }
      const double sigma_px = octave.pitch_px * level.sigma;
      // Kernels end at four standard deviations.
      EXPECT_NEAR(std::sqrt(squares / sum), sigma_px, 0.02 * sigma_px);
    }
}

TEST(ScaleSpace, OctavesHalveAndStopWhereTheImageGetsTooSmall) {
  ScaleSpaceOptions options;
  options.octaves = 12;
  const ScaleSpace space = BuildScaleSpace(cv::Mat::zeros(101, 200, CV_32FC1), options);
  ASSERT_EQ(space.size(), 3u);  // 101, 51 and 26 rows; 13 is less than kMinOctavePx
  EXPECT_EQ(space[1].levels[0].light.size(), cv::Size(100, 51));
  EXPECT_EQ(space[2].pitch_px, 4);
  EXPECT_TRUE(BuildScaleSpace(cv::Mat::zeros(10, 200, CV_32FC1), options).empty());
}

TEST(ScaleSpace, RefusesANegativeScale) {
  ScaleSpaceOptions options;
  options.sigma = -1;
  EXPECT_THROW(BuildScaleSpace(cv::Mat::zeros(50, 50, CV_32FC1), options), BadOption);
}

}  // namespace
}  // namespace gaitcam
