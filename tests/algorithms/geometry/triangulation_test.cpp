#include "algorithms/geometry/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

const Eigen::Vector3d kPoint(0.3, -0.2, 2.5);

RayObservation Seen(const Pose& X_WC, const Eigen::Vector3d& p_W, const Eigen::Vector2d& noise = {0, 0}) {
  return {X_WC, (X_WC.Inverse() * p_W).hnormalized() + noise};
}

std::vector<RayObservation> Views(int count, double baseline, double noise, uint64_t seed = 1) {
  RandomStream random(seed, "triangulation_test");
  std::vector<RayObservation> views;
  for (int i = 0; i < count; ++i) {
    const Pose X_WC(RotY(random.Uniform(-0.1, 0.1)), {i * baseline, random.Uniform(-0.01, 0.01), 0});
    views.push_back(Seen(X_WC, kPoint, noise * Eigen::Vector2d(random.Normal(), random.Normal())));
  }
  return views;
}

TEST(Triangulation, ExactRaysMeetAtThePoint) {
  for (const int count : {2, 3, 10}) {
    const auto p = TriangulatePoint(Views(count, 0.1, 0));
    ASSERT_TRUE(p);
    EXPECT_LT((*p - kPoint).norm(), 1e-9);
  }
}

TEST(Triangulation, NoisyRaysGiveTheLeastReprojectionError) {
  const auto views = Views(6, 0.1, 0.002);
  const auto p = TriangulatePoint(views);
  ASSERT_TRUE(p);
  const auto cost = [&](const Eigen::Vector3d& point) {
    double sum = 0;
    for (const auto& view : views) sum += std::pow(ReprojectionError(point, view), 2);
    return sum;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) EXPECT_GT(cost(*p + step * Eigen::Vector3d::Unit(axis)), cost(*p));
  }
}

TEST(Triangulation, WhatRaysDoNotDetermineIsNotInvented) {
  EXPECT_FALSE(TriangulatePoint({}));
  EXPECT_FALSE(TriangulatePoint({Seen(Pose(), kPoint)}));
  EXPECT_FALSE(TriangulatePoint({Seen(Pose(), kPoint), Seen(Pose(), kPoint)}));
  // Rays that meet behind the cameras.
  EXPECT_FALSE(TriangulatePoint({{Pose(), {-0.1, 0}}, {Pose(Eigen::Quaterniond::Identity(), {0.1, 0, 0}), {0.1, 0}}}));
}

TEST(Triangulation, ParallaxIsTheAngleAtThePoint) {
  const std::vector<RayObservation> views = {Seen(Pose(), {0, 0, 2}),
                                             Seen(Pose(Eigen::Quaterniond::Identity(), {2, 0, 2}), {0, 0, 2}),
                                             Seen(Pose(Eigen::Quaterniond::Identity(), {0, 0, 1}), {0, 0, 2})};
  EXPECT_NEAR(ParallaxAngle({0, 0, 2}, views), M_PI / 2, 1e-12);
}

TEST(Triangulation, BehindACameraNothingReprojects) {
  EXPECT_TRUE(std::isinf(ReprojectionError({0, 0, -1}, {Pose(), {0, 0}})));
  EXPECT_DOUBLE_EQ(ReprojectionError({0.2, 0, 1}, {Pose(), {0.1, 0}}), 0.1);
}

}  // namespace
}  // namespace gaitcam
