/// What moves a robot: from sensors to servo targets, once per control period.

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/observation.h"
#include "algorithms/core/pose.h"
#include "models/gait.h"
#include "sim/head_scan.h"

namespace gaitcam {

/// What a controller may know at one instant: sensor readings, with their noise. Truth only where the scenario grants
/// it.
struct ControlInput {
  int64_t stamp_ns = 0;
  ImuSample imu;
  JointSample joints;
  std::optional<Pose> X_WB;  ///< The root's true pose, when `path.feedback: truth`; steering uses x, y and yaw of it.
};

enum class SupportPhase { kDouble, kLeft, kRight };

/// Where in the gait a robot is; goes into the truth of every frame.
struct GaitState {
  int step = -1;                                 ///< Index of the current step; -1 while standing.
  double phase = 0;                              ///< 0..1 within the step.
  SupportPhase support = SupportPhase::kDouble;  ///< As planned.
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
  /// The path has been followed to its end and the robot stands.
  virtual bool Finished() const = 0;

  /// Asks it to stop, to look all around, and to go on. @pre not Scans().
  virtual void RequestScan(const HeadScanPlan& plan) = 0;
  /// It was asked and has not gone on yet.
  virtual bool Scans() const = 0;
  /// While the head sweeps: how far it believes to have turned on the spot since it stood.
  virtual std::optional<double> SweepTurn() const = 0;
};

}  // namespace gaitcam
