/// Other robots that stand in a view's way: pictures of one, pasted into the image (thesis, Fig. 4.9).

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/places/panorama.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "sim/camera/renderer_choice.h"

namespace gaitcam {

/// A robot by itself, seen from a camera's height straight ahead.
struct RobotPicture {
  cv::Mat bgr;            ///< CV_8UC3
  cv::Mat mask;           ///< CV_8UC1: 255 where the robot is.
  double eye_row = 0;     ///< Row at the height of the eye that sees it: where the horizon belongs.
  double middle_col = 0;  ///< Column of the robot's middle.
};

/// Renders it from all sides in the light of a scene. Needs no EglContext of the caller's, and none may be current.
/// @param eye_height_m of who sees it. @throws MissingResource if there is no EGL device.
std::vector<RobotPicture> PictureRobot(const Robot& robot, const Scene& scene, const GaitOptions& gait,
                                       const RendererChoice& renderer, double eye_height_m);

struct PastedImage {
  cv::Mat image;             ///< CV_8UC3
  double covered_ratio = 0;  ///< Of the projected view.
};

/// Robots side by side, one for each tenth of the view that is to be covered, their eyes at the horizon as those of
/// robots of one kind are, at random columns and so near that they cover `ratio` of the projected view in all.
PastedImage PasteRobots(const cv::Mat& image, const std::vector<RobotPicture>& pictures, const CameraModel& camera,
                        const Eigen::Vector3d& up_C, const CylinderProjection& projection, double ratio,
                        RandomStream& random);

}  // namespace gaitcam
