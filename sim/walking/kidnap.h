/// Somebody lifts a wheeled robot off the floor and sets it down elsewhere: the kidnapped robot of localisation.
///
/// Nobody tells it. Its cameras and its IMU feel the way; its wheels hang in the air and count nothing. It is carried
/// in a straight line, its height unchanged, with the speed of a raised cosine. See S. Thrun, W. Burgard and D. Fox,
/// "Probabilistic Robotics", section 7.1.

#pragma once

#include <Eigen/Core>

#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"

namespace gaitcam {

/// One kidnapping, as a scenario's block `kidnap` says it.
///
///   kidnap: {at_s: 20, to: [3.5, 0.1, 10], over_s: 4}
struct KidnapOptions {
  using DescribedTag = void;
  double at_s = 10;
  Eigen::Vector3d to{0, 0, 0};
  double over_s = 4;
};

template <class Visitor>
void VisitFields(Visitor& visit, KidnapOptions& o) {
  visit("at_s", o.at_s, Between(0, 36000), "when it is lifted");
  visit("to", o.to, Nested(),
        "where it is set down in the scene: x m, y m, yaw deg. Nothing may stand in between: it is carried straight");
  visit("over_s", o.over_s, Between(0.5, 600), "how long that takes");
}

/// Whether it is off the floor at a time of the run.
inline bool IsCarried(const KidnapOptions& kidnap, double time_s) {
  return time_s >= kidnap.at_s && time_s < kidnap.at_s + kidnap.over_s;
}

/// Where it is at a time of the run. @param from where it was lifted.
PlanarPose CarriedTo(const KidnapOptions& kidnap, const PlanarPose& from, double time_s);

}  // namespace gaitcam
