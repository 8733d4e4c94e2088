#include "algorithms/odometry/exposure_motion.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/units.h"
#include "algorithms/geometry/gyro_turn.h"

namespace gaitcam {
namespace {

constexpr int kSteps = 17;                // of an exposure
constexpr double kExtent2PerSpread = 12;  // of a uniform turn
constexpr double kLongAgo_s = 0.3;        // for a velocity

/// Its square times an acceleration over 24 is the distance of the mean of a motion from its middle.
double MeanOffset(double seconds) { return seconds * seconds / 24; }

}  // namespace

void ExposureMotion::Add(const Observation& observation) {
  const int64_t half_ns = std::llround(0.5 * observation.exposure_ms * kNsPerMs);
  stamp_ns_ = observation.stamp_ns;
  open_ns_ = stamp_ns_ - half_ns;
  close_ns_ = stamp_ns_ + half_ns;
  constexpr int64_t kMargin_ns = 10'000'000;
  const int64_t from_ns = std::min(open_ns_, poses_.empty() ? open_ns_ : poses_.back().stamp_ns) - kMargin_ns;
  std::erase_if(readings_, [&](const ImuSample& reading) { return reading.stamp_ns < from_ns; });
  readings_.insert(readings_.end(), observation.imu.begin(), observation.imu.end());
}

/// Readings of another time, as of a recording that was cut, are none.
bool ExposureMotion::HasGyro() const {
  constexpr int64_t kGap_ns = 20'000'000;
  return use_imu_ && !readings_.empty() && readings_.front().stamp_ns < open_ns_ + kGap_ns &&
         readings_.back().stamp_ns > close_ns_ - kGap_ns;
}

void ExposureMotion::AddPose(int64_t stamp_ns, const Pose& X_WC) {
  poses_.push_back({stamp_ns, X_WC});
  if (poses_.size() < 2) return;
  const StampedPose& last = poses_[poses_.size() - 2];
  if (last.stamp_ns < stamp_ns) LearnVelocity(last, poses_.back());
  if (poses_.size() < 3) return;
  if (poses_.size() > 3) poses_.erase(poses_.begin());
  const double before_s = double(poses_[1].stamp_ns - poses_[0].stamp_ns) * 1e-9;
  const double after_s = double(poses_[2].stamp_ns - poses_[1].stamp_ns) * 1e-9;
  if (!(before_s > 0) || !(after_s > 0)) return;
  const Vector6d before = Minus(poses_[1].pose, poses_[0].pose) / before_s;
  const Vector6d after = Minus(poses_[2].pose, poses_[1].pose) / after_s;
  const Vector6d acceleration = 2 * (after - before) / (before_s + after_s);
  constexpr double kGain = 0.2;  // of the low-pass filter
  acceleration2_ += kGain * (acceleration.head<3>().squaredNorm() / 3 - acceleration2_);
  turn_acceleration2_ += kGain * (acceleration.tail<3>().squaredNorm() / 3 - turn_acceleration2_);
}

void ExposureMotion::ForgetPoses() {
  poses_.clear();
  velocity_W_.setZero();
}

std::vector<ExposureRotation> ExposureMotion::Rotations() const {
  if (close_ns_ <= open_ns_) return {};
  if (HasGyro()) return IntegrateRotation(readings_, imu_, open_ns_, close_ns_, kSteps);
  if (poses_.size() < 2) return {};
  const StampedPose &from = poses_[poses_.size() - 2], &to = poses_.back();
  const Eigen::Vector3d rate =
      LogSo3(from.pose.rotation.conjugate() * to.pose.rotation) / (double(to.stamp_ns - from.stamp_ns) * 1e-9);
  std::vector<ExposureRotation> rotations;
  for (int i = 0; i < kSteps; ++i) {
    const int64_t at_ns = open_ns_ + (close_ns_ - open_ns_) * i / (kSteps - 1);
    rotations.push_back({at_ns, ExpSo3(-rate * (double(at_ns - stamp_ns_) * 1e-9))});
  }
  return rotations;
}

std::vector<Pose> ExposureMotion::Path() const { return PathAt(Rotations(), stamp_ns_); }

std::vector<std::vector<Pose>> ExposureMotion::PathsOfRows(double readout_ms) const {
  const std::vector<Pose> of_middle = Path();
  if (of_middle.empty()) return {};
  const int64_t half_ns = std::llround(0.5 * readout_ms * kNsPerMs);
  if (half_ns <= 0 || !HasGyro()) return {of_middle};
  std::vector<std::vector<Pose>> paths;
  for (int row = 0; row < kSteps; ++row) {
    const int64_t later_ns = 2 * half_ns * row / (kSteps - 1) - half_ns;
    paths.push_back(PathAt(IntegrateRotation(readings_, imu_, open_ns_ + later_ns, close_ns_ + later_ns, kSteps),
                           stamp_ns_ + later_ns));
  }
  return paths;
}

std::vector<Pose> ExposureMotion::ReadoutPath(double readout_ms) const {
  const int64_t half_ns = std::llround(0.5 * readout_ms * kNsPerMs);
  if (half_ns <= 0 || !HasGyro()) return {};
  return PathAt(IntegrateRotation(readings_, imu_, stamp_ns_ - half_ns, stamp_ns_ + half_ns, kSteps), stamp_ns_);
}

/// The IMU goes uniformly; the camera also turns about it.
std::vector<Pose> ExposureMotion::PathAt(const std::vector<ExposureRotation>& rotations, int64_t middle_ns) const {
  const Eigen::Vector3d velocity = Velocity(), p_I = MovingPoint();
  std::vector<Pose> path;
  for (const ExposureRotation& r : rotations) {
    const Eigen::Quaterniond R_MT = r.rotation.conjugate();
    const double seconds = 1e-9 * double(r.stamp_ns - middle_ns);
    path.push_back(Pose(R_MT, velocity * seconds + p_I - R_MT * p_I).Inverse());
  }
  return path;
}

Eigen::Vector3d ExposureMotion::MovingPoint() const {
  return HasGyro() ? imu_.X_CI.translation : Eigen::Vector3d::Zero();
}

bool ExposureMotion::KnowsVelocity() const {
  return poses_.size() >= 2 && 1e-9 * double(stamp_ns_ - poses_.back().stamp_ns) <= kLongAgo_s;
}

Eigen::Vector3d ExposureMotion::Velocity() const {
  if (!KnowsVelocity()) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d velocity_W = velocity_W_ + ChangeSince(poses_.back(), stamp_ns_).velocity;
  return (poses_.back().pose.rotation * TurnSinceLastPose()).conjugate() * velocity_W;
}

/// Visits instants between a pose and the present: (specific force in the world, seconds for which it holds, seconds
/// that remain after half of these). None without an IMU.
template <class Visit>
void ExposureMotion::IntegrateForce(const StampedPose& from, int64_t to_ns, Visit visit) const {
  if (!HasGyro() || to_ns <= from.stamp_ns) return;
  const auto turns = IntegrateRotation(readings_, imu_, from.stamp_ns, to_ns, kSteps);
  const double step_s = 1e-9 * double(to_ns - from.stamp_ns) / (kSteps - 1);
  for (int i = 0; i < kSteps; ++i) {
    const double holds_s = i == 0 || i == kSteps - 1 ? 0.5 * step_s : step_s;
    const double remain_s = i == 0            ? (kSteps - 1.25) * step_s
                            : i == kSteps - 1 ? 0.25 * step_s
                                              : (kSteps - 1 - i) * step_s;
    const Eigen::Quaterniond R_WT = from.pose.rotation * turns.front().rotation * turns[size_t(i)].rotation.conjugate();
    visit(R_WT * (imu_.X_CI.rotation * ReadingAt(turns[size_t(i)].stamp_ns).specific_force), holds_s, remain_s);
  }
}

ExposureMotion::Change ExposureMotion::ChangeSince(const StampedPose& from, int64_t to_ns) const {
  Change change;
  IntegrateForce(from, to_ns, [&](const Eigen::Vector3d& force_W, double holds_s, double remain_s) {
    const Eigen::Vector3d step = holds_s * (force_W - force_W_);
    change.velocity += step;
    change.position += remain_s * step;
  });
  return change;
}

/// Over a walk the head stays at one speed: the mean specific force is gravity's.
void ExposureMotion::LearnVelocity(const StampedPose& before, const StampedPose& now) {
  IntegrateForce(before, now.stamp_ns, [&](const Eigen::Vector3d& force_W, double holds_s, double) {
    force_s_ += holds_s;
    force_W_ += holds_s / force_s_ * (force_W - force_W_);
  });
  const double seconds = 1e-9 * double(now.stamp_ns - before.stamp_ns);
  const Eigen::Vector3d p_I = MovingPoint();
  const Change change = ChangeSince(before, now.stamp_ns);
  const Eigen::Vector3d before_W = (now.pose * p_I - before.pose * p_I - change.position) / seconds;
  constexpr double kGain = 0.25;  // of what two poses say; their errors are opposite in the next such measurement
  if (poses_.size() == 2 || !HasGyro() || seconds > kLongAgo_s) {
    velocity_W_ = before_W;
  } else {
    velocity_W_ += kGain * (before_W - velocity_W_);
  }
  velocity_W_ += change.velocity;
}

Eigen::Quaterniond ExposureMotion::TurnSinceLastPose() const {
  if (!HasGyro() || poses_.empty() || poses_.back().stamp_ns >= stamp_ns_) return Eigen::Quaterniond::Identity();
  const auto turns = IntegrateRotation(readings_, imu_, poses_.back().stamp_ns, stamp_ns_, 2);
  return turns.front().rotation * turns.back().rotation.conjugate();
}

Pose ExposureMotion::PredictPose() const {
  const Pose& last = poses_.back().pose;
  const Eigen::Quaterniond R_WC = last.rotation * TurnSinceLastPose();
  if (!KnowsVelocity()) return {R_WC, last.translation};
  const double seconds = 1e-9 * double(stamp_ns_ - poses_.back().stamp_ns);
  const Eigen::Vector3d p_I = MovingPoint();
  const Change change = ChangeSince(poses_.back(), stamp_ns_);
  return {R_WC, last * p_I + seconds * velocity_W_ + change.position - R_WC * p_I};
}

double ExposureMotion::TurnSigma() const {
  if (poses_.empty()) return 0;
  const double seconds = double(stamp_ns_ - poses_.back().stamp_ns) * 1e-9;
  constexpr double kHead_rad_s = 2;
  if (!HasGyro() || !(seconds > 0)) return kHead_rad_s * std::max(0.0, seconds);
  const double turn = RotationAngle(Eigen::Quaterniond::Identity(), TurnSinceLastPose());
  const double change = (ReadingAt(stamp_ns_).angular_rate - ReadingAt(poses_.back().stamp_ns).angular_rate).norm();
  return Eigen::Vector3d(BenchGyro::kMisaligned_rad * turn, BenchGyro::kOffset_s * change,
                         BenchGyro::kBias_rad_s * seconds)
      .norm();
}

Eigen::Matrix3d ExposureMotion::RateCovariance(double readout_ms) const {
  const int64_t half_ns = std::llround(0.5 * readout_ms * kNsPerMs);
  if (half_ns <= 0 || !HasGyro()) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d middle = ReadingAt(stamp_ns_).angular_rate;
  Eigen::Matrix3d covariance = std::pow(BenchGyro::kMisaligned_rad, 2) *
                               (middle.squaredNorm() * Eigen::Matrix3d::Identity() - middle * middle.transpose());
  for (const int64_t end_ns : {-half_ns, half_ns}) {
    const Eigen::Vector3d late =
        BenchGyro::kOffset_s / (1e-9 * double(half_ns)) * (ReadingAt(stamp_ns_ + end_ns).angular_rate - middle);
    covariance += 0.5 * late * late.transpose();
  }
  const Eigen::Matrix3d R_CI = imu_.X_CI.R();
  return R_CI * covariance * R_CI.transpose();
}

/// The first at or after an instant.
/// @pre HasGyro()
const ImuSample& ExposureMotion::ReadingAt(int64_t stamp_ns) const {
  const auto after = std::lower_bound(readings_.begin(), readings_.end(), stamp_ns,
                                      [](const ImuSample& reading, int64_t at) { return reading.stamp_ns < at; });
  return after == readings_.end() ? readings_.back() : *after;
}

Eigen::Matrix3d ExposureMotion::TurnSpread() const {
  const std::vector<ExposureRotation> rotations = Rotations();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ExposureRotation& r : rotations) mean += LogSo3(r.rotation) / double(rotations.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const ExposureRotation& r : rotations) {
    const Eigen::Vector3d turn = LogSo3(r.rotation) - mean;
    spread += turn * turn.transpose() / double(rotations.size());
  }
  return spread;
}

double ExposureMotion::Extent() const { return std::sqrt(kExtent2PerSpread * TurnSpread().trace()); }

Matrix6d ExposureMotion::UnknownMotion(double part) const {
  const double offset = MeanOffset(double(close_ns_ - open_ns_) * 1e-9);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(acceleration2_ * offset * offset);
  covariance.bottomRightCorner<3, 3>() = part * part * kExtent2PerSpread * TurnSpread();
  if (!HasGyro()) covariance.diagonal().tail<3>().array() += turn_acceleration2_ * offset * offset;
  return covariance;
}

}  // namespace gaitcam
