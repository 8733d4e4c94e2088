/// A system made worse on purpose: the proof that a gate catches what it should.

#pragma once

#include <memory>
#include <optional>

#include "algorithms/core/random.h"
#include "algorithms/slam/system.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

/// Whether it changes anything.
bool IsHandicap(const HandicapOptions& options);

/// What the system is told instead of the truth about its cameras.
Calibration FalsifiedCalibration(Calibration calibration, const HandicapOptions& options);

/// Keeps frames from the system (its inertial and joint readings come with the next one), stops it, and spoils the
/// poses that it gives, live and final.
class HandicappedSystem : public System {
 public:
  HandicappedSystem(std::unique_ptr<System> system, const HandicapOptions& options, uint64_t seed);

  FrameEstimate Track(const Observation& observation) override;
  FinalEstimate Finish() override;
  BodyCommand Command() const override { return system_->Command(); }

 private:
  /// What is done to a sequence of poses: one for the live answer, one for the final.
  struct Spoiler {
    std::optional<Pose> before, bent;  ///< The pose before as it was given, and with the path bent.
    int poses = 0;
  };

  void Spoil(FrameEstimate& frame, Spoiler& spoiler);
  Pose Bend(const Pose& pose, Spoiler& spoiler) const;

  std::unique_ptr<System> system_;
  HandicapOptions options_;
  RandomStream random_;
  bool is_garbage_;
  int64_t frame_ = 0;
  bool had_pose_ = false;
  Spoiler live_;
  std::vector<ImuSample> imu_;  ///< Of dropped frames, not handed over yet.
  std::vector<JointSample> joints_;
  std::vector<OdometrySample> odometry_;
};

}  // namespace gaitcam
