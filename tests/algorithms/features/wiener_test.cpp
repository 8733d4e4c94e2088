#include "algorithms/features/wiener.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

constexpr int kWienerMargin = 32;

double RootMeanSquare(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(double(a.total()));
}

struct Pictures {
  cv::Mat sharp, blurred;
};

Pictures Make(const LineBlur& blur) {
  const cv::Mat picture = RandomPicture({384, 304}, 5);
  return {Values(BlurAndCrop(picture, {}, kWienerMargin)), Values(BlurAndCrop(picture, blur, kWienerMargin))};
}

TEST(Wiener, RestoredIsNearerToTheSharpThanTheBlurred) {
  for (const LineBlur blur : {LineBlur{10, 0.3}, LineBlur{20, 1.2}, LineBlur{35, 2.5}}) {
    const Pictures p = Make(blur);
    WienerOptions options;
    options.border_passes = 2;
    const cv::Mat restored = RestoreWiener(p.blurred, blur, options);
    ASSERT_EQ(restored.size(), p.sharp.size());
    EXPECT_LT(RootMeanSquare(restored, p.sharp), 0.75 * RootMeanSquare(p.blurred, p.sharp)) << blur.extent_px;
  }
}

TEST(Wiener, AWrongDirectionMakesItWorse) {
  const LineBlur blur{20, 1.2};
  const Pictures p = Make(blur);
  EXPECT_GT(RootMeanSquare(RestoreWiener(p.blurred, {20, 1.2 + M_PI / 2}, {}), p.sharp),
            RootMeanSquare(RestoreWiener(p.blurred, blur, {}), p.sharp));
}

TEST(Wiener, AConsistentMarginRestoresBetterNearTheBorder) {
  const LineBlur blur{30, 0.4};
  const Pictures p = Make(blur);
  WienerOptions mirrored, consistent;
  mirrored.gamma = consistent.gamma = 0.005;
  consistent.border_passes = 5;
  EXPECT_LT(RootMeanSquare(RestoreWiener(p.blurred, blur, consistent), p.sharp),
            0.95 * RootMeanSquare(RestoreWiener(p.blurred, blur, mirrored), p.sharp));
}

TEST(Wiener, LeavesAnUnblurredImageAloneButForItsGain) {
  const cv::Mat image = Values(RandomPicture({100, 80}, 6));
  WienerOptions options;
  options.gamma = 0.01;
  const cv::Mat restored = RestoreWiener(image, LineBlur{}, options);
  EXPECT_LT(cv::norm(restored * 1.01, image, cv::NORM_INF), 1e-4);  // H = 1: W = 1 / (1 + gamma)
}

TEST(Wiener, RegionsWithTheSameBlurAreLikeTheWhole) {
  const LineBlur blur{12, 0.4};
  const Pictures p = Make(blur);
  const int w = p.blurred.cols, h = p.blurred.rows;
  const BlurEstimate certain{blur, 1, true};
  const cv::Mat whole = RestoreWiener(p.blurred, blur, {});
  const cv::Mat parts =
      RestoreRegions(p.blurred, {{{0, 0, w / 2, h}, certain}, {{w / 2, 0, w - w / 2, h}, certain}}, {});
  ASSERT_EQ(parts.size(), whole.size());
  const cv::Rect away(w / 2 + 40, 40, w / 2 - 80, h - 80);  // from what a part does not see
  EXPECT_LT(RootMeanSquare(parts(away), whole(away)), 0.25 * RootMeanSquare(p.blurred(away), whole(away)));
  EXPECT_LT(RootMeanSquare(parts, p.sharp), RootMeanSquare(p.blurred, p.sharp));
}

TEST(Wiener, ASharpRegionStaysAsItIs) {
  const cv::Mat image = Values(RandomPicture({120, 90}, 6));
  const cv::Mat restored = RestoreRegions(image, {{{0, 0, 60, 90}, {}}, {{60, 0, 60, 90}, {}}}, {});
  EXPECT_LT(cv::norm(restored, image, cv::NORM_INF), 1e-6);
}

TEST(Wiener, TransferIsEquation55) {
  const LineBlur blur{8, 0};
  WienerOptions options;
  options.gamma = 0.02;
  const WienerTransfer wiener(blur, options);
  const Eigen::ArrayXf fx = Eigen::ArrayXf::LinSpaced(5, 0, 0.4f);
  Eigen::ArrayXf w(5);
  wiener.Row(fx, 0.1f, w);
  for (int i = 0; i < 5; ++i) {
    const double u = M_PI * 8 * fx[i], h = u > 0 ? std::sin(u) / u : 1;
    EXPECT_NEAR(w[i], h / (h * h + 0.02), 1e-4);
  }
}

TEST(Wiener, RefusesAGammaOfZero) {
  WienerOptions options;
  options.gamma = 0;
  EXPECT_THROW(RestoreWiener(cv::Mat::zeros(40, 40, CV_32FC1), {8, 0}, options), BadOption);
}

}  // namespace
}  // namespace gaitcam
