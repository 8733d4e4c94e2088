#include "algorithms/odometry/fused_rotations.h"

#include <cmath>

namespace gaitcam {

FusedRotations::FusedRotations(const ImuCalibration& imu)
    : noise_density_(imu.gyro_noise_density),
      gyro_(imu),
      exposure_(imu, true),
      chain_(gyro_.bias_sigma(), imu.gyro_random_walk) {}

void FusedRotations::Begin(const Observation& observation) {
  constexpr double kSharp_rad = 0.002;  // of the rotation that a sharp image says, about each axis
  constexpr double kBesides = 0.15;     // of the turn over the exposure, about each axis
  gyro_.Add(observation.imu);
  exposure_.Add(observation);
  present_ = {};
  if (last_ns_) {
    present_.turn = gyro_.Between(*last_ns_, observation.stamp_ns);
    present_.seconds = 1e-9 * double(observation.stamp_ns - *last_ns_);
  }
  if (present_.turn) {
    present_.sigma =
        std::hypot(BenchGyro::kMisaligned_rad * present_.turn->norm(), noise_density_ * std::sqrt(present_.seconds));
  }
  const double besides = std::hypot(kSharp_rad, kBesides * exposure_.Extent());
  present_.spread = exposure_.TurnSpread() + besides * besides * Eigen::Matrix3d::Identity();
  last_ns_ = observation.stamp_ns;
  constexpr int64_t kPeriods_ns = 100'000'000;
  gyro_.DropBefore(*last_ns_ - kPeriods_ns);
}

RotationChain::Rotation FusedRotations::Predicted() const { return chain_.Predict(present_); }

void FusedRotations::Fuse(FrameEstimate& answer) {
  const RotationChain::Rotation image = answer.pose ? RotationChain::Rotation(answer.pose->rotation) : std::nullopt;
  const RotationChain::Rotation fused = chain_.Add(present_, image, answer.restarted);
  if (image) answer.pose->rotation = *fused;
}

void FusedRotations::Smooth(std::vector<FrameEstimate>& frames) const {
  std::vector<RotationChain::Rotation> images;
  for (const FrameEstimate& frame : frames)
    images.push_back(frame.pose ? RotationChain::Rotation(frame.pose->rotation) : std::nullopt);
  const std::vector<RotationChain::Rotation> smoothed = chain_.Smoothed(images);
  for (size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].pose) frames[k].pose->rotation = *smoothed[k];
  }
}

}  // namespace gaitcam
