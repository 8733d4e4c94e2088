#include "algorithms/odometry/metric_answers.h"

namespace gaitcam {
namespace {

/// Short, so that the gyroscope's unknown bias tilts little; what accelerations do to it, the mean over frames removes.
constexpr double kGravityTime_s = 0.5;

}  // namespace

MetricAnswers::MetricAnswers(const Calibration& calibration)
    : up_C_(calibration.imu, calibration.standing->up_C, kGravityTime_s), scale_(calibration.standing->height_m) {}

void MetricAnswers::Follow(const Pose& X_WC, int64_t stamp_ns) {
  carried_.Add(stamp_ns, X_WC.rotation * up_C(), X_WC.translation);
}

std::optional<CarriedHeight> MetricAnswers::AddKeyframe(const KeyframeMap& map) {
  auto measured = MeasureCarriedHeight(map, carried());
  scale_.Add(measured, false);
  return measured;
}

void MetricAnswers::GiveUpMap() {
  carried_.Restart();
  held_since_ns_.reset();
  out_of_patience_ = is_known_ = false;
}

Pose MetricAnswers::InMetres(const Pose& X_WC) const {
  return Pose(X_WC.rotation, at_m_ + factor_ * (X_WC.translation - at_));
}

FrameEstimate MetricAnswers::InMetres(FrameEstimate answer, bool has_map) {
  constexpr int64_t kPatience_ns = 2'000'000'000;
  const std::optional<double> factor = has_map ? scale_.latest() : std::nullopt;
  if (answer.pose && !held_since_ns_) held_since_ns_ = answer.stamp_ns;
  out_of_patience_ |= answer.pose && answer.stamp_ns - *held_since_ns_ >= kPatience_ns;
  const bool hold_back = answer.pose && !factor && !out_of_patience_;
  if (answer.pose && !hold_back) {
    answer.restarted |= restarts_ || (factor && !is_known_ && out_of_patience_);
    restarts_ = false;
    is_known_ = factor.has_value();
    factor_ = factor.value_or(factor_);
  }
  if (hold_back) {
    restarts_ |= answer.restarted;
    answer.status = TrackingStatus::kInitializing;
    answer.restarted = false;
    answer.predicted = Pose(answer.pose->rotation, at_m_);
    answer.pose.reset();
  } else if (answer.pose) {
    const Eigen::Vector3d position = answer.pose->translation;
    answer.pose = InMetres(*answer.pose);
    at_ = position;
    at_m_ = answer.pose->translation;
  } else if (answer.predicted) {
    answer.predicted = InMetres(*answer.predicted);
  }
  return answer;
}

}  // namespace gaitcam
