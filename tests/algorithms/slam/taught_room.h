// A robot with wheels, depth and a camera in a textured room: the map that it learns there, and a drive by it in which
// what it commands moves it.

#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <variant>
#include <vector>

#include "algorithms/core/planar_pose.h"
#include "algorithms/slam/hybrid_drive.h"
#include "algorithms/slam/hybrid_slam.h"
#include "tests/algorithms/odometry/odometry_trials.h"

namespace gaitcam {

inline Calibration DepthAndWheels() {
  Calibration calibration = OneCamera();
  calibration.has_depth = true;
  calibration.odometry.rate_hz = 60;
  calibration.odometry.X_BC = LookingForward({0.1, 0, 0.5}, 0, -0.3, 0);
  calibration.odometry.position_per_sqrt_m = 0.02;
  calibration.odometry.heading_per_sqrt_m = 0.01;
  return calibration;
}

/// A base that does at once what it is told, seen and measured without error but for the picture's noise.
class RoomBase {
 public:
  explicit RoomBase(const PlanarPose& X_WB) : X_WB_(X_WB) {}

  Observation Look() {
    const Pose X_WC = X_WB_.Lifted() * DepthAndWheels().odometry.X_BC;
    const Film still = FilmPath(
        Room(), kCamera, 1, [&](double) { return X_WC; }, 5, 1);
    Observation observation = still.frames.front();
    observation.stamp_ns = observation.image.stamp_ns = stamp_ns_;
    observation.depth = Image{stamp_ns_, Room().Depth(kCamera, X_WC)};
    observation.odometry = std::move(readings_);
    observation.odometry.push_back({stamp_ns_, X_OB_.position, X_OB_.heading});
    readings_.clear();
    return observation;
  }

  void Drive(const Velocity& velocity) {
    constexpr int kParts = 10;
    for (int part = 1; part <= kParts; ++part) {
      const double dt = kFrame_s / kParts;
      const PlanarPose moved({velocity.forward_mps * dt, velocity.left_mps * dt}, velocity.turn_rad_s * dt);
      X_WB_ = X_WB_ * moved;
      X_OB_ = X_OB_ * moved;
      stamp_ns_ += int64_t(1e9 * dt);
      if (part < kParts) readings_.push_back({stamp_ns_, X_OB_.position, X_OB_.heading});
    }
  }

  /// Somewhere else at once; the wheels do not turn.
  void CarryTo(const PlanarPose& X_WB) { X_WB_ = X_WB; }

  const PlanarPose& X_WB() const { return X_WB_; }

  static constexpr double kFrame_s = 0.2;

 private:
  PlanarPose X_WB_, X_OB_;
  int64_t stamp_ns_ = 1'000'000'000;
  std::vector<OdometrySample> readings_;
};

inline const PlanarPose kTaughtStart({-1.8, 0.1}, 0);
constexpr double kTaught_m = 1.6;

/// Of a straight drive along x.
inline std::shared_ptr<const RouteMap> TaughtLane() {
  static const std::shared_ptr<const RouteMap> map = [] {
    HybridSlamOptions options;
    options.sight.sensitivity = 4;  // small pictures with noise: the weakest features are of the noise
    options.model_m = 0.1;
    HybridSlam slam(DepthAndWheels(), options, 1);
    RoomBase base(kTaughtStart);
    for (double way_m = 0; way_m < kTaught_m; way_m += 0.4 * RoomBase::kFrame_s) {
      slam.Track(base.Look());
      base.Drive({0.4, 0, 0});
    }
    slam.Finish();
    return std::make_shared<const RouteMap>(slam.Learned());
  }();
  return map;
}

}  // namespace gaitcam
