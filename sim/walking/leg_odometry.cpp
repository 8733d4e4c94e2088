#include "sim/walking/leg_odometry.h"

#include <cmath>

#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

constexpr double kRest_rad_s =
    0.05;  // the gyroscope of a robot that stands shows no more; twice a usual bias and noise

}  // namespace

LegOdometry::LegOdometry(const Robot& robot, double rate_hz)
    : estimator_(robot, EstimatorOptions(), Pose()), rate_hz_(rate_hz) {}

std::vector<OdometrySample> LegOdometry::Update(const std::vector<ImuSample>& imu,
                                                const std::vector<JointSample>& joints) {
  imu_.insert(imu_.end(), imu.begin(), imu.end());
  std::vector<OdometrySample> samples;
  for (const JointSample& reading : joints) {
    TakeImuUntil(reading.stamp_ns);
    if (next_ == 0) first_ns_ = last_ns_ = reading.stamp_ns;
    Read(reading);
    last_ns_ = reading.stamp_ns;
    if (reading.stamp_ns - first_ns_ < std::llround(double(next_) * 1e9 / rate_hz_)) continue;
    ++next_;
    const PlanarPose X_OB(estimator_.X_OB());
    heading_ += WrapAngle(X_OB.heading - heading_);
    samples.push_back({reading.stamp_ns, X_OB.position, heading_});
  }
  return samples;
}

/// Where none is new, the mean before holds.
void LegOdometry::TakeImuUntil(int64_t stamp_ns) {
  ImuSample sum;
  int count = 0;
  for (; !imu_.empty() && imu_.front().stamp_ns <= stamp_ns; imu_.pop_front(), ++count) {
    sum.stamp_ns = imu_.front().stamp_ns;
    sum.angular_rate += imu_.front().angular_rate;
    sum.specific_force += imu_.front().specific_force;
  }
  if (count > 0) mean_ = {sum.stamp_ns, sum.angular_rate / count, sum.specific_force / count};
}

void LegOdometry::Read(const JointSample& joints) {
  if (joints.left_contact != joints.right_contact) {
    stance_ = joints.left_contact ? 0 : 1;
    walked_ = true;
  }
  const bool rests = !walked_ && mean_.stamp_ns > 0 && mean_.angular_rate.norm() < kRest_rad_s;
  estimator_.UpdateBase(mean_, joints.position, 1e-9 * double(joints.stamp_ns - last_ns_), stance_, rests);
}

OdometryCalibration LegDataSheet(double rate_hz) {
  // The shipped humanoids slip by 0.2 to 4 % of their way, always backwards, and turn by up to 0.7 degrees in 2 to 3 m
  // or a circle beside what the gyroscope says (tests/sim/walking/leg_odometry_test.cpp). Slip grows with the way, not
  // with its root: it counts here as much as 3 % amount to after 10 m.
  OdometryCalibration sheet;
  sheet.rate_hz = rate_hz;
  sheet.position_per_sqrt_m = 0.03 * std::sqrt(10.0);
  sheet.heading_per_sqrt_m = 0.006;
  sheet.heading_per_sqrt_rad = 0.005;
  sheet.rocking_m = 0.002;
  sheet.rocking_rad = 0.04;
  return sheet;
}

}  // namespace gaitcam
