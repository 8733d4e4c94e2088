/// Image motion during the exposure: for each pixel, the displacement of the point that it sees.

#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "models/code/people/person_walk.h"

namespace gaitcam {

/// Where the camera and all bodies were at one instant.
struct SceneInstant {
  int64_t stamp_ns = 0;
  Pose X_WC;
  std::vector<Pose> X_WB;  ///< By MuJoCo's body numbers; 0 is the world. Parts of people are bodies, too.
};

/// @param with_people if not, the identity stands for the poses of their parts, until PoseSeenPeople puts some there.
SceneInstant CaptureInstant(const mjModel* model, const mjData& data, int camera_id, int64_t stamp_ns,
                            bool with_people = true);

/// The bodies in a picture of labels (CV_32SC1), ascending; the world alone, 0, if that is empty.
std::vector<int> SeenBodies(const cv::Mat& bodies);

/// Poses the parts of people among the bodies that are seen. @param people of the model, in their order.
void PoseSeenPeople(const mjModel* model, const std::vector<PersonWalk>& people, std::span<const int> seen,
                    SceneInstant& instant);

/// Motion of a body relative to the camera: maps the position of a point of it in the camera frame at one instant to
/// that at another.
Pose RelativeMotion(const SceneInstant& from, const SceneInstant& to, int body);

/// Points that the camera sees at one instant, each fixed to the body it lies on.
class SeenPoints {
 public:
  /// Every `stride`-th pixel in both directions, and the last row and column.
  /// @param rays CV_32FC2, (X/Z, Y/Z) of each pixel.
  /// @param depth CV_32FC1, m; where it is 0, the point lies infinitely far away.
  /// @param bodies CV_32SC1, or empty when only the world is seen.
  SeenPoints(const cv::Mat& rays, const cv::Mat& depth, const cv::Mat& bodies, const SceneInstant& at, int stride);

  size_t size() const { return p_C_.size(); }
  /// Pixel coordinates of each point at another instant; NaN for a point that is then behind the camera.
  std::vector<Eigen::Vector2d> Project(const CameraModel& camera, const SceneInstant& at) const;

 private:
  SceneInstant seen_at_;
  std::vector<Eigen::Vector3d> p_C_;
  std::vector<int> body_;
};

/// Net motion from open to close of the point seen at each pixel at `middle`, CV_32FC2, px. A point moves with the body
/// it lies on: the robot's own parts and those of people have their own motion besides the camera's.
/// @param bands opening and closing instants of equally high bands of rows from top to bottom: one for a global
/// shutter,
///        several follow a rolling one.
cv::Mat BlurVectors(const CameraModel& camera, const cv::Mat& rays, const cv::Mat& depth, const cv::Mat& bodies,
                    const SceneInstant& middle, const std::vector<std::pair<SceneInstant, SceneInstant>>& bands);

/// Lengths of the paths that points take through the image.
struct PathLengths {
  double median_px = 0, p90_px = 0, max_px = 0;
};

PathLengths MeasurePaths(const CameraModel& camera, const SeenPoints& points,
                         const std::vector<SceneInstant>& instants);

}  // namespace gaitcam
