#include "algorithms/odometry/body_track.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gaitcam {
namespace {

/// What is known no better than this, so that a covariance has an inverse.
constexpr double kNeverBelow_m = 1e-3, kNeverBelow_rad = 1e-4;

/// Of a short motion, in the frame at its end (OdometryCalibration).
Eigen::Matrix3d Grown(const PlanarPose& step, const OdometryCalibration& c) {
  const double way = step.position.norm(), turn = std::abs(step.heading);
  const double position2 = c.position_per_sqrt_m * c.position_per_sqrt_m * way;
  const double heading2 = c.heading_per_sqrt_m * c.heading_per_sqrt_m * way +  //
                          c.heading_per_sqrt_rad * c.heading_per_sqrt_rad * turn;
  return Eigen::Vector3d(position2, position2, heading2).asDiagonal();
}

/// Of the body's motion in space, given its part in the floor (x, y, yaw). Its rocking counts once, as of one instant,
/// though a motion has it at both ends: the variance is half of what it would be if the two were independent.
Matrix6d InSpace(const Eigen::Matrix3d& planar, const OdometryCalibration& c) {
  constexpr std::array kRows = {0, 1, 5};
  Matrix6d covariance = Matrix6d::Zero();
  const double height2 = c.rocking_m * c.rocking_m, tilt2 = c.rocking_rad * c.rocking_rad;
  covariance.diagonal() << 0, 0, height2, tilt2, tilt2, 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      covariance(kRows[size_t(row)], kRows[size_t(column)]) = planar(row, column);
  }
  covariance.diagonal() += (Vector6d() << Eigen::Vector3d::Constant(kNeverBelow_m * kNeverBelow_m),
                            Eigen::Vector3d::Constant(kNeverBelow_rad * kNeverBelow_rad))
                               .finished();
  return covariance;
}

auto FirstAfter(const std::deque<OdometrySample>& samples, int64_t stamp_ns) {
  return std::partition_point(samples.begin(), samples.end(),
                              [&](const OdometrySample& sample) { return sample.stamp_ns <= stamp_ns; });
}

}  // namespace

BodyTrack::BodyTrack(const OdometryCalibration& calibration, const ImuCalibration& imu) : calibration_(calibration) {
  if (imu.rate_hz > 0) gyro_.emplace(imu);
}

void BodyTrack::Add(const std::vector<OdometrySample>& samples, const std::vector<ImuSample>& imu) {
  if (gyro_) gyro_->Add(imu);
  samples_.insert(samples_.end(), samples.begin(), samples.end());
}

void BodyTrack::Forget(int64_t before_ns) {
  while (samples_.size() > 2 && samples_[1].stamp_ns <= before_ns) samples_.pop_front();
  constexpr int64_t kPeriod_ns = 100'000'000;  // no IMU samples more slowly
  if (gyro_) gyro_->DropBefore(before_ns - kPeriod_ns);
}

std::optional<PlanarPose> BodyTrack::At(int64_t stamp_ns) const {
  constexpr double kBeyond = 2;  // sampling intervals
  if (samples_.size() < 2 || stamp_ns < samples_.front().stamp_ns) return std::nullopt;
  const auto after = FirstAfter(samples_, stamp_ns);
  const OdometrySample& b = after == samples_.end() ? samples_.back() : *after;
  const OdometrySample& a = samples_[size_t((after == samples_.end() ? after - 1 : after) - samples_.begin()) - 1];
  const double s = double(stamp_ns - a.stamp_ns) / double(b.stamp_ns - a.stamp_ns);
  if (s > 1 + kBeyond) return std::nullopt;
  return PlanarPose((1 - s) * a.position + s * b.position, (1 - s) * a.heading + s * b.heading);
}

std::optional<RelativePose> BodyTrack::Between(int64_t from_ns, int64_t to_ns) const {
  const std::optional<PlanarPose> from = At(from_ns), to = At(to_ns);
  if (!from || !to) return std::nullopt;
  // Along the samples, since errors grow with the way and not with how far it led.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  PlanarPose last = *from;
  const auto grow = [&](const PlanarPose& next) {
    const PlanarPose step = last.Inverse() * next;
    const Eigen::Matrix3d carry = PlanarAdjoint(step.Inverse());
    covariance = carry * covariance * carry.transpose() + Grown(step, calibration_);
    last = next;
  };
  for (auto sample = FirstAfter(samples_, from_ns); sample != samples_.end() && sample->stamp_ns < to_ns; ++sample)
    grow(PlanarPose(sample->position, sample->heading));
  grow(*to);
  const Pose& X_BC = calibration_.X_BC;
  const Pose X_FT = X_BC.Inverse() * (from->Inverse() * *to).Lifted() * X_BC;
  RelativePose moved{from_ns, to_ns, X_FT, CarryCovariance(InSpace(covariance, calibration_), X_BC)};
  TurnByGyroscope(moved);
  return moved;
}

/// Over short times a gyroscope with a bias that nobody has learned knows the turn of a body that rocks better. Wheels
/// do not rock, and know it better themselves.
void BodyTrack::TurnByGyroscope(RelativePose& moved) const {
  constexpr double kRocks_rad = 0.02;
  if (!gyro_ || calibration_.rocking_rad < kRocks_rad) return;
  const double time_s = 1e-9 * double(moved.to_ns - moved.from_ns);
  const double sigma = std::hypot(gyro_->bias_sigma() * time_s, kNeverBelow_rad);
  if (sigma >= calibration_.rocking_rad) return;
  const std::optional<Eigen::Vector3d> turn = gyro_->Between(moved.from_ns, moved.to_ns);
  if (!turn) return;
  moved.X_FT.rotation = ExpSo3(*turn);
  moved.covariance.topRightCorner<3, 3>().setZero();
  moved.covariance.bottomLeftCorner<3, 3>().setZero();
  moved.covariance.bottomRightCorner<3, 3>() = sigma * sigma * Eigen::Matrix3d::Identity();
}

}  // namespace gaitcam
