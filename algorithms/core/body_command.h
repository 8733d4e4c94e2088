/// What a system may ask of the body that carries its camera, in answer to each frame.
///
/// A command holds until another one is given; the same command again changes nothing. A body that cannot do what is
/// asked says so in one line (BadInput) and the run ends. A run that ends "when the path ends" needs a duration if its
/// system leaves the path.

#pragma once

#include <variant>

namespace gaitcam {

/// Follow the scenario's path from where it was left.
struct FollowPath {
  bool operator==(const FollowPath&) const = default;
};

/// Stop, stand, look all around, then go on with what was commanded before. Observation::scan is set meanwhile.
struct Scan {
  bool operator==(const Scan&) const = default;
};

/// Walk at constant velocity, in the robot's own frame (x forward, y left). What the body cannot reach is clamped to
/// its limits; zero means stand.
struct Velocity {
  double forward_mps = 0;
  double left_mps = 0;
  double turn_rad_s = 0;  ///< About the vertical, left positive.
  bool operator==(const Velocity&) const = default;
};

/// Go to a place on the floor and stand there. Relative to where the robot believes it stands when the command is first
/// given: x forward, y left, then heading (left positive) at the goal.
struct GoTo {
  double x_m = 0;
  double y_m = 0;
  double heading_rad = 0;
  bool operator==(const GoTo&) const = default;
};

/// Nothing is left to be done: the run ends here.
struct EndWalk {
  bool operator==(const EndWalk&) const = default;
};

using BodyCommand = std::variant<FollowPath, Scan, Velocity, GoTo, EndWalk>;

}  // namespace gaitcam
