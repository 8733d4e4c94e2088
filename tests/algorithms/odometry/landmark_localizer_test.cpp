#include "algorithms/odometry/landmark_localizer.h"

#include <gtest/gtest.h>

#include <vector>

namespace gaitcam {
namespace {

constexpr double kFocal_px = 280, kSigma_px = 0.4;
constexpr int kKnown = 20;

/// What a camera sees of points; each has a descriptor of its own, the same in all views.
FrameView ViewOf(const std::vector<Eigen::Vector3d>& points, const Pose& X_WC, uint64_t seed) {
  RandomStream noise(seed, "noise"), random(4, "descriptors");
  FrameView view;
  view.X_WC = X_WC;
  const Pose X_CW = X_WC.Inverse();
  const double sigma = kSigma_px / kFocal_px;
  for (const Eigen::Vector3d& p_W : points) {
    view.xy.push_back((X_CW * p_W).hnormalized() + sigma * Eigen::Vector2d(noise.Normal(), noise.Normal()));
    view.sigma.push_back(sigma);
  }
  view.features.descriptors = cv::Mat(int(points.size()), 16, CV_32FC1);
  for (float& value : cv::Mat_<float>(view.features.descriptors)) value = float(random.Uniform(0, 1));
  return view;
}

/// Two keyframes of a wall about 1 m away, so that its depth is known; in the second another one, 4 m away, has come
/// into view, whose depth is assumed to be that of the first.
struct NearAndFarWall {
  std::vector<Eigen::Vector3d> points;
  KeyframeMap map{KeyframeMapOptions()};

  explicit NearAndFarWall(int far_points) {
    RandomStream random(1, "points");
    for (int i = 0; i < kKnown; ++i) {
      points.emplace_back(random.Uniform(-0.5, 0.5), random.Uniform(-0.4, 0.4), random.Uniform(0.8, 1.2));
    }
    for (int i = 0; i < far_points; ++i) points.emplace_back(random.Uniform(-2, 2), random.Uniform(-1.5, 1.5), 4);
    const auto no_prior = [](const Pose&, const Eigen::Vector2d&) { return std::optional<DepthPrior>(); };
    FrameView first = Seen(Pose(Eigen::Quaterniond::Identity(), {-0.2, 0, 0}), kKnown, 2),
              second = Seen(Pose(), int(points.size()), 3);
    map.AddKeyframe(first, {}, 1, no_prior);
    std::vector<LandmarkMatch> matches;
    for (int i = 0; i < kKnown; ++i) {
      map.SetDepth(i, 1 / points[size_t(i)].z());
      matches.push_back({i, i});
    }
    map.AddKeyframe(second, matches, 1, no_prior);
  }

  FrameView Seen(const Pose& X_WC, int count, uint64_t seed) const {
    return ViewOf({points.begin(), points.begin() + count}, X_WC, seed);
  }
};

TEST(LandmarkLocalizer, TheDepthAssumedOfNewLandmarksIsNoMeasureOfMotion) {
  const NearAndFarWall scene(600);
  const LandmarkLocalizer localizer(kFocal_px, 0.8, LandmarkLocalizerOptions());
  const Pose moved(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.02, 0, 0.02));
  PosePrediction prediction;
  prediction.prior = localizer.PredictPosition(0.7 * moved.translation, 100'000'000, 1);
  RandomStream random(5, "ransac");
  const auto found = localizer.Localize(scene.map, scene.Seen(moved, int(scene.points.size()), 6), prediction, random);
  ASSERT_TRUE(found);
  // 7 mm were measured. By the assumed depth the step is 28 / 4 mm long, 21 mm off: 16 mm were measured where each
  // new landmark has its say, and none of the known ones is an inlier then.
  EXPECT_LT((found->X_WC.translation - moved.translation).norm(), 0.012);
  int known = 0;
  for (const LandmarkMatch& match : found->inliers) known += match.feature < kKnown;
  EXPECT_GT(known, kKnown * 2 / 3);
}

TEST(LandmarkLocalizer, WhatLooksOtherwiseIsNoMatchThoughNothingElseIsNear) {
  constexpr int kLandmarks = 400, kSeen = 80;
  RandomStream random(1, "wall");
  std::vector<Eigen::Vector3d> wall;
  for (int i = 0; i < kLandmarks; ++i) {
    wall.emplace_back(random.Uniform(-1, 1), random.Uniform(-0.8, 0.8), random.Uniform(1.8, 2.2));
  }
  KeyframeMap map{KeyframeMapOptions()};
  FrameView first = ViewOf(wall, Pose(), 2);
  map.AddKeyframe(first, {}, 2, [](const Pose&, const Eigen::Vector2d&) { return DepthPrior{0.5, 0.03}; });

  // Other things have come before most of the wall, twice as many as were seen of it.
  const Pose moved(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.02, 0, 0.02));
  std::vector<Eigen::Vector3d> seen(wall.begin(), wall.begin() + kSeen);
  for (int i = 0; i < 2 * kLandmarks; ++i) seen.emplace_back(random.Uniform(-1, 1), random.Uniform(-0.8, 0.8), 2);
  FrameView second = ViewOf(seen, moved, 3);
  cv::Mat_<float> descriptors = second.features.descriptors;
  for (int i = kSeen; i < descriptors.rows; ++i) {
    for (float& value : cv::Mat_<float>(descriptors.row(i))) value = float(random.Uniform(0, 1));
  }
  for (float& value : descriptors) value += float(0.05 * random.Normal());

  const LandmarkLocalizer localizer(kFocal_px, 0.8, LandmarkLocalizerOptions());
  PosePrediction prediction;
  prediction.prior = localizer.PredictPosition(Eigen::Vector3d::Zero(), 100'000'000, 2);
  RandomStream ransac(5, "ransac");
  const auto found = localizer.Localize(map, second, prediction, ransac);
  ASSERT_TRUE(found);
  int right = 0;
  for (const LandmarkMatch& match : found->inliers) right += match.landmark == match.feature;
  EXPECT_GT(right, kSeen * 3 / 4);
  EXPECT_LE(int(found->inliers.size()) - right, 2);
  EXPECT_LT(found->matches, kSeen * 5 / 4);
}

}  // namespace
}  // namespace gaitcam
