#include "algorithms/places/scan_controller.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

ScanController::ScanController(const CylinderProjection& projection, const PanoramaLayout& layout,
                               const Options& options)
    : projection_(projection), layout_(layout), options_(options) {}

std::optional<ScanController::Scan> ScanController::Add(const Observation& observation, double heading_rad) {
  if (failed_) return std::nullopt;
  const int64_t now_ns = observation.stamp_ns;
  if (wants_scan() && asked_ns_ < 0) {
    asked_ns_ = now_ns;
    asked_heading_rad_ = heading_rad;
  }
  if (observation.scan) {
    AddScanFrame(observation, heading_rad);
  } else if (wants_scan()) {
    if (builder_ && builder_->missing_deg() == 0) {
      ended_ns_ = now_ns;
      return End();
    }
    failed_ = double(now_ns - asked_ns_) * 1e-9 > options_.patience_s;
  } else if (state_ == State::kSettling && Settled(observation)) {
    state_ = State::kWalking;
  }
  return std::nullopt;
}

void ScanController::AddScanFrame(const Observation& observation, double heading_rad) {
  if (!wants_scan()) {
    state_ = State::kSettling;
    ended_ns_ = observation.stamp_ns;
    return;
  }
  if (state_ == State::kAsking) {
    state_ = State::kScanning;
    builder_.emplace(projection_, layout_, options_.panorama);
    ahead_rad_ = BodyHeading(heading_rad, observation.scan->pan_rad);
    began_ns_ = observation.stamp_ns;
  }
  builder_->Add(observation.image.pixels, observation.scan->pan_rad + observation.scan->body_turn_rad);
}

/// The body has come to a halt since the scan was asked for. A gyroscope in the head has also turned by `pan_rad`, to
/// where a sweep begins, which is so far that the two cannot be mistaken for each other.
double ScanController::BodyHeading(double heading_rad, double pan_rad) const {
  const double turned = heading_rad - asked_heading_rad_;
  return std::abs(turned - pan_rad) < std::abs(turned) ? heading_rad - pan_rad : heading_rad;
}

bool ScanController::Settled(const Observation& observation) const {
  if (double(observation.stamp_ns - ended_ns_) * 1e-9 < options_.settle_s) return false;
  const auto on_one_leg = std::count_if(observation.joints.begin(), observation.joints.end(),
                                        [](const JointSample& s) { return s.left_contact != s.right_contact; });
  return observation.joints.empty() || 2 * size_t(on_one_leg) >= observation.joints.size();
}

ScanController::Scan ScanController::End() {
  Scan scan{builder_->Finish(), began_ns_, ahead_rad_};
  builder_.reset();
  asked_ns_ = -1;
  state_ = State::kSettling;
  return scan;
}

std::optional<ScanController::Scan> ScanController::Finish() {
  if (!builder_ || builder_->missing_deg() > 0) return std::nullopt;
  return End();
}

void ScanController::Ask() {
  GAITCAM_ASSERT(state_ == State::kWalking);
  state_ = State::kAsking;
}

std::string ScanController::MissingText() const {
  if (builder_) {
    return "a scan left " + std::to_string(builder_->missing_deg()) + " of 360 deg unseen, after " +
           std::to_string(builder_->frames()) + " frames";
  }
  return "it asked for a scan and none came: it needs a robot that looks around as it is asked to, not a recorded walk";
}

}  // namespace gaitcam
