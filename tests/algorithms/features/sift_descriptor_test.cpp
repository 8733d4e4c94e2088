#include "algorithms/features/sift_descriptor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

Features Describe(const cv::Mat& grey, const SiftOptions& options = {}) {
  cv::Mat light;
  grey.convertTo(light, CV_32F, 1 / 255.0);
  const ScaleSpace space = BuildScaleSpace(light, {});
  return DescribeSift(space, DetectHessian(space, {}), options);
}

/// Index of the keypoint nearest to a place whose scale agrees to a fifth and whose orientation to 10 degrees; -1:
/// none.
int FindNear(const Features& features, const cv::Point2f& place, float size, float angle) {
  int best = -1;
  double nearest = 1.5;
  for (int i = 0; i < features.size(); ++i) {
    const cv::KeyPoint& k = features.keypoints[size_t(i)];
    const double apart = cv::norm(k.pt - place), turn = std::fmod(std::abs(k.angle - angle), 360);
    if (apart < nearest && std::abs(std::log(k.size / size)) < 0.2 && std::min(turn, 360 - turn) < 10) {
      nearest = apart;
      best = i;
    }
  }
  return best;
}

TEST(SiftDescriptor, HasUnitLengthAndNoNegativeEntry) {
  for (const bool root : {false, true}) {
    SiftOptions options;
    options.root = root;
    const Features features = Describe(RandomPicture({320, 240}, 1), options);
    ASSERT_GT(features.size(), 100);
    for (int i = 0; i < features.size(); ++i) {
      const cv::Mat row = features.descriptors.row(i);
      double least = 0;
      cv::minMaxLoc(row, &least);
      EXPECT_GE(least, 0);
      EXPECT_NEAR(cv::norm(row), 1, 1e-5);
    }
  }
}

TEST(SiftDescriptor, TurnsWithTheImage) {
  const cv::Mat picture = RandomPicture({321, 321}, 2);
  cv::Mat turned;
  cv::rotate(picture, turned, cv::ROTATE_90_CLOCKWISE);  // pixel (x, y) goes to (320 - y, x); angles grow by 90 degrees
  const Features a = Describe(picture), b = Describe(turned);
  int found = 0;
  double distance = 0;
  for (int i = 0; i < a.size(); ++i) {
    const cv::KeyPoint& k = a.keypoints[size_t(i)];
    const int j = FindNear(b, {320 - k.pt.y, k.pt.x}, k.size, std::fmod(k.angle + 90, 360.f));
    if (j < 0) continue;
    ++found;
    distance += cv::norm(a.descriptors.row(i), b.descriptors.row(j));
  }
  // A quarter turn maps pixels to pixels, but every second pixel of an octave begins at the other end.
  EXPECT_GT(found, 0.9 * a.size());
  EXPECT_LT(distance / found, 0.15);  // unrelated descriptors are about 1 apart
}

TEST(SiftDescriptor, DoesNotSeeBrightnessAndContrast) {
  const cv::Mat picture = RandomPicture({320, 240}, 3);
  cv::Mat pale;
  picture.convertTo(pale, CV_8U, 0.6, 60);
  const Features a = Describe(picture), b = Describe(pale);
  int found = 0;
  double distance = 0;
  for (int i = 0; i < b.size(); ++i) {
    const cv::KeyPoint& k = b.keypoints[size_t(i)];
    const int j = FindNear(a, k.pt, k.size, k.angle);
    if (j < 0) continue;
    ++found;
    distance += cv::norm(b.descriptors.row(i), a.descriptors.row(j));
  }
  EXPECT_GT(found, 0.95 * b.size());
  EXPECT_LT(distance / found, 0.05);  // what rounding to whole grey values does
}

TEST(SiftDescriptor, FurtherEntriesTellKindsApart) {
  SiftOptions options;
  options.kind_weight = 0.3;
  ASSERT_EQ(SiftLength(options), kSiftLength + 3);
  ScalePoint dark, bright;
  dark.level = bright.level = 1;
  dark.x = bright.x = dark.y = bright.y = 60;
  dark.scale = bright.scale = 2;
  bright.kind = PointKind::kBright;
  cv::Mat light;
  RandomPicture({120, 120}, 4).convertTo(light, CV_32F, 1 / 255.0);
  const ScaleSpace space = BuildScaleSpace(light, {});
  const Features a = DescribeSift(space, {dark}, options), b = DescribeSift(space, {bright}, options);
  ASSERT_EQ(a.descriptors.cols, SiftLength(options));
  EXPECT_NEAR(cv::norm(a.descriptors.row(0), b.descriptors.row(0)), 0.3 * std::sqrt(2), 1e-6);
}

TEST(SiftDescriptor, OrientationIsUphillClockwiseOnTheScreen) {
  cv::Mat ramp(100, 100, CV_32FC1);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) ramp.at<float>(y, x) = 0.004f * float(x + y);
  ScalePoint p;
  p.level = 1;
  p.x = p.y = 50;
  p.scale = 2;
  const Features features = DescribeSift(BuildScaleSpace(ramp, {}), {p}, {});
  ASSERT_EQ(features.size(), 1);
  EXPECT_NEAR(features.keypoints[0].angle, 45, 0.5);  // right and DOWN, as OpenCV has it
  EXPECT_NEAR(features.keypoints[0].size, 4, 1e-6);
}

/// Responses and descriptors, sorted: the features in an order that depends on nothing but themselves.
std::vector<std::vector<float>> Sorted(const Features& features) {
  std::vector<std::vector<float>> all;
  for (int i = 0; i < features.size(); ++i) {
    all.push_back({-features.keypoints[size_t(i)].response});
    const float* row = features.descriptors.ptr<float>(i);
    all.back().insert(all.back().end(), row, row + features.descriptors.cols);
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(SiftDescriptor, TheStrongestAreTheSameWhetherAllAreDescribedOrNot) {
  cv::Mat light;
  RandomPicture({320, 240}, 4).convertTo(light, CV_32F, 1 / 255.0);
  const ScaleSpace space = BuildScaleSpace(light, {});
  const std::vector<ScalePoint> points = DetectHessian(space, {});
  const auto all = Sorted(DescribeSift(space, points, {}));
  for (const size_t most : {size_t(1), size_t(40), points.size(), all.size() - 1, all.size() + 1}) {
    auto strongest = Sorted(DescribeSift(space, points, {}, int(most)));
    ASSERT_GE(strongest.size(), std::min(most, all.size()));
    EXPECT_LT(strongest.size(), most + 8) << "one point more, with all its orientations";
    for (size_t i = 0; i < std::min(most, all.size()); ++i) ASSERT_EQ(strongest[i], all[i]) << most;
  }
}

}  // namespace
}  // namespace gaitcam
