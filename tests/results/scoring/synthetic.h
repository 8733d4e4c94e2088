// Trajectories and runs made up for the tests of this folder.

#pragma once

#include <cmath>
#include <numbers>

#include "algorithms/core/estimate.h"
#include "algorithms/core/random.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/alignment.h"

namespace gaitcam {

inline constexpr int64_t kFrame_ns = 33'333'333;

/// A camera looking along `heading` (about world z), level: its z axis forward, x right, y down.
inline Eigen::Matrix3d LookAlong(double heading) {
  Eigen::Matrix3d R_WC;  // columns: x right, y down, z forward, for heading 0
  R_WC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return RotZ(heading) * R_WC;
}

/// A walk on a circle of `radius_m`, turning left by `turn_rad` in all, with the sway of a gait in position and
/// attitude.
inline Trajectory SwayingCircle(int frames, double radius_m, double turn_rad) {
  Trajectory trajectory;
  for (int i = 0; i < frames; ++i) {
    const double s = frames > 1 ? double(i) / (frames - 1) : 0, heading = s * turn_rad, sway = 0.6 * i;
    const Eigen::Vector3d p(radius_m * std::sin(heading), radius_m * (1 - std::cos(heading)) + 0.01 * std::sin(sway),
                            0.3 + 0.004 * std::sin(2 * sway));
    const Eigen::Matrix3d R = LookAlong(heading + 0.05 * std::sin(sway)) * RotX(0.1 + 0.02 * std::sin(sway + 1));
    trajectory.push_back({1'000'000'000 + i * kFrame_ns, Pose(R, p)});
  }
  return trajectory;
}

inline Eigen::Quaterniond RandomRotation(RandomStream& random) {
  Eigen::Quaterniond q(random.Normal(), random.Normal(), random.Normal(), random.Normal());
  return q.normalized();
}

inline Similarity RandomSimilarity(RandomStream& random, bool with_scale) {
  Similarity X;
  X.scale = with_scale ? std::exp(random.Uniform(-2, 2)) : 1;
  X.rotation = RandomRotation(random);
  X.translation = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()) * 5;
  return X;
}

inline Trajectory Moved(const Similarity& X, Trajectory trajectory) {
  for (StampedPose& p : trajectory) p.pose = X * p.pose;
  return trajectory;
}

/// The trajectory with white noise on positions and rotations.
inline Trajectory Noisy(Trajectory trajectory, RandomStream& random, double sigma_m, double sigma_rad) {
  for (StampedPose& p : trajectory) {
    const Eigen::Vector3d w = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()) * sigma_rad;
    const Eigen::AngleAxisd turn(w.norm(), w.norm() > 0 ? w.normalized() : Eigen::Vector3d::UnitX());
    p.pose.rotation = (p.pose.rotation * Eigen::Quaterniond(turn)).normalized();
    p.pose.translation += Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()) * sigma_m;
  }
  return trajectory;
}

inline std::vector<int64_t> Stamps(const Trajectory& trajectory) {
  std::vector<int64_t> stamps;
  for (const StampedPose& p : trajectory) stamps.push_back(p.stamp_ns);
  return stamps;
}

inline std::vector<PosePair> PairUp(const Trajectory& truth, const Trajectory& estimate) {
  std::vector<PosePair> pairs;
  for (size_t i = 0; i < truth.size(); ++i) pairs.push_back({truth[i].stamp_ns, truth[i].pose, estimate[i].pose, {}});
  return pairs;
}

}  // namespace gaitcam
