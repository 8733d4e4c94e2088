// Two views of points, for tests of two-view geometry.

#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "algorithms/core/median.h"
#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/epipolar.h"

namespace gaitcam {

inline constexpr double kFocalPx = 277;  // 320 px at 60 degrees; noise is given in pixels of such a camera

struct ViewPairs {
  Pose X_AB;
  std::vector<PointPair> pairs;
  int outliers = 0;
};

enum class Scene { kDeep, kPlane };

// Points 1 to 4 m before camera A in a 60 degree field of view, or on a slanted plane 2 m away; the last `outliers`
// pairs are random.
inline ViewPairs MakeViewPairs(Scene scene, const Pose& X_AB, int count, int outliers, double noise_px, uint64_t seed) {
  RandomStream random(seed, "view_pairs");
  ViewPairs views{X_AB, {}, outliers};
  const auto anywhere = [&] { return Eigen::Vector2d(random.Uniform(-0.57, 0.57), random.Uniform(-0.43, 0.43)); };
  const auto noise = [&]() -> Eigen::Vector2d {
    return Eigen::Vector2d(random.Normal(), random.Normal()) * noise_px / kFocalPx;
  };
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.5, 1).normalized();
  while (int(views.pairs.size()) < count - outliers) {
    const Eigen::Vector2d a = anywhere();
    const double depth = scene == Scene::kPlane ? 2 / normal.dot(a.homogeneous()) : random.Uniform(1, 4);
    const Eigen::Vector3d p_B = X_AB.Inverse() * (depth * a.homogeneous());
    views.pairs.push_back({a + noise(), p_B.hnormalized() + noise()});
  }
  for (int i = 0; i < outliers; ++i) views.pairs.push_back({anywhere(), anywhere()});
  return views;
}

inline Pose SomeMotion() { return Pose(RotY(0.08) * RotX(-0.05) * RotZ(0.1), {0.3, -0.05, 0.2}); }

// A random motion: up to 0.2 rad about each axis, 0.2 to 0.5 m anywhere.
inline Pose RandomMotion(uint64_t seed) {
  RandomStream random(seed, "motion");
  const Eigen::Vector3d direction(random.Normal(), random.Normal(), random.Normal());
  const Eigen::Matrix3d R =
      RotX(random.Uniform(-0.2, 0.2)) * RotY(random.Uniform(-0.2, 0.2)) * RotZ(random.Uniform(-0.2, 0.2));
  return Pose(R, random.Uniform(0.2, 0.5) * direction.normalized());
}

inline Eigen::Matrix3d TrueEssential(const Pose& X_AB) {
  const Pose X_BA = X_AB.Inverse();
  return Hat(X_BA.translation.normalized()) * X_BA.R();
}

// Distance of two essential matrices of norm sqrt 2, whose sign means nothing.
inline double EssentialDistance(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d p = a * (std::sqrt(2.0) / a.norm()), q = b * (std::sqrt(2.0) / b.norm());
  return std::min((p - q).norm(), (p + q).norm());
}

inline double DirectionError(const Pose& estimate, const Pose& truth) {
  return std::acos(std::clamp(estimate.translation.normalized().dot(truth.translation.normalized()), -1.0, 1.0));
}

}  // namespace gaitcam
