/// What the legs of a humanoid say of its way over the floor, from what its sensors read: joint encoders and foot
/// switches say where the trunk is above the foot that stands, the gyroscope which way it faces (StateEstimator). The
/// standing foot is assumed not to slip nor to turn; where it does, the odometry errs.

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "models/code/robots/robot.h"
#include "sim/walking/state_estimator.h"

namespace gaitcam {

class LegOdometry {
 public:
  /// @param rate_hz of its samples; no more than one for each reading of the joints.
  LegOdometry(const Robot& robot, double rate_hz);

  /// @param imu, joints readings since the last call, in time order.
  /// @returns samples, stamped as the joints' readings they are made of. The first one is of the first reading.
  std::vector<OdometrySample> Update(const std::vector<ImuSample>& imu, const std::vector<JointSample>& joints);

 private:
  void TakeImuUntil(int64_t stamp_ns);
  void Read(const JointSample& joints);

  StateEstimator estimator_;
  double rate_hz_;
  std::deque<ImuSample> imu_;  ///< Later than the last reading of the joints.
  ImuSample mean_;             ///< Over the time since the reading of the joints before.
  int stance_ = -1;            ///< The foot that carried it last alone.
  bool walked_ = false;
  double heading_ = 0;  ///< Not wrapped.
  int64_t first_ns_ = 0, last_ns_ = 0, next_ = 0;
};

/// What a data sheet of the legs says. Its X_BC is left at the identity.
OdometryCalibration LegDataSheet(double rate_hz);

}  // namespace gaitcam
