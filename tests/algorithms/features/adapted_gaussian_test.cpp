#include "algorithms/features/adapted_gaussian.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

/// Sum of squared differences of equation 5.16 along the blur, at whole pixels.
double Cost(double sigma, double extent, double adapted) {
  double cost = 0;
  for (int i = -100; i <= 100; ++i) {
    const double root = std::sqrt(2.0) * adapted;
    const double blurred = (std::erf((i + extent / 2) / root) - std::erf((i - extent / 2) / root)) / (2 * extent);
    const double d = std::exp(-i * i / (2 * sigma * sigma)) / (std::sqrt(2 * M_PI) * sigma) - blurred;
    cost += d * d;
  }
  return cost;
}

TEST(AdaptedGaussian, WithoutBlurItIsTheRoundOne) {
  for (const double sigma : {0.8, 1.6, 6.4, 20.0}) {
    EXPECT_EQ(AdaptedSigma(sigma, 0), sigma);
    EXPECT_NEAR(AdaptedSigma(sigma, 0.05), sigma, 1e-3 * sigma);
  }
}

TEST(AdaptedGaussian, TheThesisExample) {
  // Figure 5.10: extent 18 at scale 6.4 gives 3.69.
  EXPECT_NEAR(AdaptedSigma(6.4, 18), 3.69, 0.15);
}

TEST(AdaptedGaussian, NoOtherSigmaIsNearer) {
  for (const double sigma : {3.2, 6.4, 12.8})
    for (const double extent : {4.0, 8.0, 11.0}) {
      const double best = AdaptedSigma(sigma, extent);
      for (const double factor : {0.5, 0.9, 0.98, 1.02, 1.1}) {
        if (factor * best > sigma) continue;
        EXPECT_LE(Cost(sigma, extent, best), Cost(sigma, extent, factor * best) * (1 + 1e-9)) << sigma << " " << extent;
      }
    }
}

TEST(AdaptedGaussian, ShrinksAsTheBlurGrows) {
  double last = 7;
  for (const double extent : {0.0, 4.0, 8.0, 12.0, 16.0, 20.0}) {
    const double adapted = AdaptedSigma(6.4, extent);
    EXPECT_LT(adapted, last);
    EXPECT_GT(adapted, 0);
    last = adapted;
  }
}

TEST(AdaptedGaussian, MemoryGivesTheSameWhateverCameBefore) {
  AdaptedSigmaCache one, two;
  two(6.4, 12.01);
  EXPECT_EQ(one(6.4, 12.02), two(6.4, 12.02));
  EXPECT_NEAR(one(6.4, 12.0), AdaptedSigma(6.4, 12.0), 1e-9);
}

TEST(AdaptedGaussian, MakesTheBlurredLookLikeTheSharp) {
  // Figure 5.10: the smoothed blurred image is nearer to the smoothed sharp one, the Gaussian being turned into the
  // blur.
  const LineBlur blur{18, 5 * M_PI / 6};
  const cv::Mat picture = RandomPicture({360, 300}, 1);
  cv::Mat sharp, blurred;
  BlurAndCrop(picture, {}, 30).convertTo(sharp, CV_32F, 1 / 255.0);
  BlurAndCrop(picture, blur, 30).convertTo(blurred, CV_32F, 1 / 255.0);
  ScaleSpaceOptions options;
  options.sigma = 6.4;
  options.octaves = 1;
  AdaptedSigmaCache cache;
  const auto first_level = [&](const cv::Mat& image, const LineBlur& made_up_for) {
    return BuildAdaptedScaleSpace(image, made_up_for, options, cache).front().levels.front().light;
  };
  const cv::Mat wanted = first_level(sharp, {});
  const double adapted = cv::norm(first_level(blurred, blur), wanted),
               round = cv::norm(first_level(blurred, {}), wanted);
  EXPECT_LT(adapted, 0.4 * round);
}

TEST(AdaptedGaussian, WithoutBlurTheScaleSpaceIsTheRoundOne) {
  cv::Mat light;
  RandomPicture({200, 160}, 2).convertTo(light, CV_32F, 1 / 255.0);
  AdaptedSigmaCache cache;
  ScaleSpaceOptions options;
  options.octaves = 3;
  const ScaleSpace adapted = BuildAdaptedScaleSpace(light, {}, options, cache), round = BuildScaleSpace(light, options);
  ASSERT_EQ(adapted.size(), round.size());
  for (size_t o = 0; o < round.size(); ++o)
    for (size_t l = 0; l < round[o].levels.size(); ++l) {
      const cv::Mat &a = adapted[o].levels[l].light, &b = round[o].levels[l].light;
      ASSERT_EQ(a.size(), b.size());
      const cv::Rect middle(a.cols / 4, a.rows / 4, a.cols / 2, a.rows / 2);
      EXPECT_LT(cv::norm(a(middle), b(middle), cv::NORM_INF), 0.01);  // kernels end at four standard deviations
    }
}

}  // namespace
}  // namespace gaitcam
