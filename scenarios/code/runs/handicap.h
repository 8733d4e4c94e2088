/// A system made worse on purpose: the proof that a gate catches what it should.

#pragma once

#include <memory>

#include "algorithms/core/random.h"
#include "algorithms/slam/system.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

/// Whether it changes anything.
bool IsHandicap(const HandicapOptions& options);

/// What the system is told instead of the truth about its cameras.
Calibration FalsifiedCalibration(Calibration calibration, const HandicapOptions& options);

/// Keeps every n-th frame from the system (its inertial and joint readings come with the next one) and adds noise to
/// the poses that the system gives.
class HandicappedSystem : public System {
 public:
  HandicappedSystem(std::unique_ptr<System> system, const HandicapOptions& options, uint64_t seed);

  FrameEstimate Track(const Observation& observation) override;
  FinalEstimate Finish() override;
  BodyCommand Command() const override { return system_->Command(); }

 private:
  void Disturb(FrameEstimate& frame);

  std::unique_ptr<System> system_;
  HandicapOptions options_;
  RandomStream random_;
  int64_t frame_ = 0;
  bool had_pose_ = false;
  std::vector<ImuSample> imu_;  ///< Of dropped frames, not handed over yet.
  std::vector<JointSample> joints_;
};

}  // namespace gaitcam
