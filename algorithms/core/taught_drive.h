/// How a robot went by a map that it was taught: the route it chose, and what it knew and did at each frame.
///
/// The taught floor frame F is the body's frame where the map's first view was taken: origin on the floor below the
/// trunk, x forward, y left.

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

enum class DriveState {
  kSearching,  ///< It does not know where it is, or whether this is the goal; it stands.
  kDriving,    ///< ... along its route.
  kWaiting,    ///< Something is in its way; it stands, or slows down to stand.
  kArrived,
};
constexpr auto WordsOf(DriveState) {
  return std::array{EnumWord{DriveState::kSearching, "searching"}, EnumWord{DriveState::kDriving, "driving"},
                    EnumWord{DriveState::kWaiting, "waiting"}, EnumWord{DriveState::kArrived, "arrived"}};
}

struct DriveStep {
  int64_t stamp_ns = 0;
  DriveState state = DriveState::kSearching;
  bool confirmed = false;  ///< A view of the map says where it is, and no other place fits; else the wheels alone do.
  bool found = false;      ///< It takes itself to be elsewhere than before: a start, or after being carried off.
  int places = 0;          ///< In so many it may be, as far as it knows.
  PlanarPose X_FB = {};    ///< Of the body, if it knows: the first of these places.
};

/// A way that was planned along views of the map.
struct DriveRoute {
  int from_step = 0;              ///< Of TaughtDrive::steps.
  std::vector<int64_t> views_ns;  ///< Stamps of its views, of the walk that taught them.
};

struct TaughtDrive {
  Pose X_BC;                       ///< Of the calibration that it drove with.
  double half_view_rad = 0;        ///< Half of the camera's horizontal field of view, likewise.
  std::vector<DriveRoute> routes;  ///< One after the other.
  std::vector<DriveStep> steps;
};

}  // namespace gaitcam
