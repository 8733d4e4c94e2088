/// Interface of a robot's controller: from sensor readings to servo targets, once per control period.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/body_command.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/frame_truth.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/pose.h"
#include "models/code/robots/gait.h"
#include "sim/walking/head_scan.h"

namespace gaitcam {

/// What a controller may know at one instant: sensor readings, with their noise. Truth only where the scenario grants
/// it.
struct ControlInput {
  int64_t stamp_ns = 0;
  ImuSample imu;
  JointSample joints;
  std::optional<Pose> X_WB;  ///< The root's true pose, when `path.feedback: truth`; steering uses x, y and yaw of it.
};

class Controller {
 public:
  virtual ~Controller() = default;
  /// Joint positions (order of Robot::joints) and root pose to start from.
  virtual std::vector<double> InitialJoints() const = 0;
  virtual Pose InitialRoot() const = 0;
  /// Servo targets in the order of Robot::joints.
  virtual const std::vector<double>& Update(const ControlInput& input) = 0;
  virtual GaitState gait() const = 0;
  /// The path has been followed to its end and the robot stands, with no other command to serve.
  virtual bool Finished() const = 0;

  /// What it is to do from now on; the same command again changes nothing. What it cannot reach it clamps. The wheeled
  /// base keeps a velocity to a per cent and a goal to a centimetre. A humanoid sets its feet for the velocity, and
  /// slides on up to a quarter more; it arrives within 5 cm and 0.1 rad (KHR-1HV; tests/sim/walking). It comes to stand
  /// between two commands, but for one velocity after another, and answers a second or two late: its footprints are
  /// planned ahead.
  /// @pre not a Scan, which takes a plan: see below.
  virtual void Command(const BodyCommand& command) = 0;

  /// Somebody holds it there; let go, it goes on from there with its command, or back to its path. @pre a wheeled base.
  virtual void Hold(const PlanarPose& /*pose*/) { GAITCAM_ASSERT(false); }

  /// Asks it to stop, to look all around, and to go on. @pre not Scans().
  virtual void RequestScan(const HeadScanPlan& plan) = 0;
  /// It was asked and has not gone on yet.
  virtual bool Scans() const = 0;
  /// While the head sweeps: how far it believes to have turned on the spot since it stood.
  virtual std::optional<double> SweepTurn() const = 0;
};

}  // namespace gaitcam
