#include "algorithms/odometry/fused_rotations.h"

#include <cmath>

namespace gaitcam {

FusedRotations::FusedRotations(const ImuCalibration& imu)
    : noise_density_(imu.gyro_noise_density),
      gyro_(imu),
      exposure_(imu, true),
      chain_(gyro_.bias_sigma(), imu.gyro_random_walk) {}

void FusedRotations::Begin(const Observation& observation) {
  constexpr double kSharp_rad = 0.002;  // standard deviation about each axis of what a sharp image says
  // What a blurred image says is wrong by this part of the turn over the exposure about each axis, besides showing any
  // instant of it. Chosen among 0.15, 0.3 and 0.6 on the lit walks of results/studies/thresholds.
  constexpr double kBesides = 0.3;
  gyro_.Add(observation.imu);
  exposure_.Add(observation);
  turn_ = {};
  if (last_ns_) {
    turn_.turn = gyro_.Between(*last_ns_, observation.stamp_ns);
    turn_.seconds = 1e-9 * double(observation.stamp_ns - *last_ns_);
  }
  if (turn_.turn) {
    turn_.sigma =
        std::hypot(BenchGyro::kMisaligned_rad * turn_.turn->norm(), noise_density_ * std::sqrt(turn_.seconds));
  }
  const double besides = std::hypot(kSharp_rad, kBesides * exposure_.Extent());
  turn_.spread = exposure_.TurnSpread() + besides * besides * Eigen::Matrix3d::Identity();
  last_ns_ = observation.stamp_ns;
  constexpr int64_t kPeriods_ns = 100'000'000;
  gyro_.DropBefore(*last_ns_ - kPeriods_ns);
}

RotationChain::Rotation FusedRotations::Predicted() const { return chain_.Predict(turn_); }

void FusedRotations::Add(const RotationChain::Rotation& R_WC, bool begins) {
  image_ = R_WC;
  rotation_ = chain_.Add(turn_, R_WC, begins);
  said_.push_back(Eigen::Quaterniond::Identity());
}

Eigen::Quaterniond FusedRotations::SeenFrom() {
  Eigen::Quaterniond nearest = *rotation_;
  for (const ExposureRotation& then : exposure_.Rotations()) {
    const Eigen::Quaterniond R_WT = *rotation_ * then.rotation.conjugate();
    if (RotationAngle(R_WT, *image_) < RotationAngle(nearest, *image_)) nearest = R_WT;
  }
  said_.back() = nearest.conjugate() * *image_;
  return nearest;
}

void FusedRotations::Smooth(std::vector<FrameEstimate>& frames) const {
  std::vector<RotationChain::Rotation> images(frames.size());
  for (size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].pose) images[k] = frames[k].pose->rotation * said_[k];
  }
  const std::vector<RotationChain::Rotation> smoothed = chain_.Smoothed(images);
  for (size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].pose) frames[k].pose->rotation = *smoothed[k];
  }
}

}  // namespace gaitcam
