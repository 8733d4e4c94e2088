/// How far the way ahead is free, by what the depth camera sees. People come first: nothing of the map is asked.
///
/// A depth camera is blind below its least distance and beside its view. What was seen there last is believed for
/// `memory_s`, unless the camera has seen what is behind it since.
///
/// Who walks is met at his speed, not at the robot's: what is now where the frames before saw past has moved there,
/// and is given room to come on until the robot stands.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"

namespace gaitcam {

struct WayGuardOptions {
  using DescribedTag = void;
  double body_radius_m = 0.22;
  double clearance_m = 0.3;
  double look_m = 2.0;
  double memory_s = 5;
  double walker_mps = 1.4;
  int min_points = 12;
  double pose_error_deg = 0;
};

template <class Visitor>
void VisitFields(Visitor& visit, WayGuardOptions& o) {
  visit("body_radius_m", o.body_radius_m, Between(0.01, 10), "of the robot, seen from above");
  visit("clearance_m", o.clearance_m, Between(0, 10), "to what stands in the way, which it comes no nearer than");
  visit("look_m", o.look_m, Between(0.1, 100), "what lies farther along the way counts not yet");
  visit("memory_s", o.memory_s, Between(0, 3600), "so long it believes in what it saw where it does not see now");
  visit("walker_mps", o.walker_mps, Between(0, 5), "so fast what has moved may come towards the robot");
  visit("min_points", o.min_points, Between(1, 100000),
        "points, of every eighth pixel of row and column, that stand in the way: fewer are noise");
  visit("pose_error_deg", o.pose_error_deg, Between(0, 10),
        "how wrong it may be known where the camera looks, as on a head that rocks: so near to the edge of something "
        "that was there before nothing counts as having moved");
}

class WayGuard {
 public:
  /// @throws BadInput if the calibration does not know how the camera stands on the body; BadOption.
  WayGuard(const Calibration& calibration, const WayGuardOptions& options);

  /// The next frame. @param depth CV_32FC1, m. @param X_FC where the camera is; it may be tilted beside X_BC.
  void See(int64_t stamp_ns, const Pose& X_FC, const cv::Mat& depth);
  /// Of no use any more, where the floor frame was another one than was thought.
  void Forget();

  /// @param ahead where the body's middle will be after so many metres, in F.
  /// @returns how far the body may go on until something is within `clearance_m` of it, m; `look_m` if nothing is.
  double FreeWay(const std::function<Eigen::Vector2d(double along_m)>& ahead) const;

  /// How the robot comes to stand.
  struct Stop {
    double brake_mps2;  ///< What it slows down by.
    double reaction_s;  ///< Until it begins to.
    double going_m;     ///< How far it goes by what it was told before.
  };
  /// How fast the robot may be so that it stands when somebody who moves gets as near as `clearance_m`, m/s.
  double SpeedAmongWalkers(const Stop& stop) const;

 private:
  /// A picture, and where it was taken.
  struct View {
    cv::Mat depth;
    Pose X_CF;
  };
  struct Point {
    Eigen::Vector3d p_F;
    int64_t stamp_ns;
  };
  /// Points over the floor that this frame shows.
  std::vector<Point> PointsOf(int64_t stamp_ns, const Pose& X_FC, const cv::Mat& depth) const;
  /// What a view measured in the direction of a point, m along the optical axis: 0 nothing; nothing at all where the
  /// point is not in view.
  std::optional<double> DepthTowards(const Eigen::Vector3d& p_F, const View& view) const;
  bool HasMoved(const Eigen::Vector3d& p_F) const;
  double NearestMoving(const std::vector<Point>& points, const Eigen::Vector2d& body_F) const;

  Calibration calibration_;
  WayGuardOptions options_;
  std::vector<Point> points_;
  std::vector<View> before_;  ///< The last frames, each pixel the least within pose_error_deg of it; oldest first.
  std::vector<std::pair<int64_t, double>> moving_;  ///< Stamps, and how near to the robot something moved.
};

}  // namespace gaitcam
