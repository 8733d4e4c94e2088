/// A camera that flies freely through a small scene along a path of the test's choosing: no robot, no physics.

#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "sim/camera/blur_field.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"

namespace gaitcam {

/// 160 x 120 px, 60 degrees wide, without distortion.
inline CameraModel SmallCamera() { return CameraModel::FromHorizontalFov(160, 120, 60); }

/// An image as the model's file of that name.
inline std::pair<std::string, std::vector<unsigned char>> PngFile(const std::string& name, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  return {name, bytes};
}

/// Random dots, as a stand-in for any texture: blurred noise with strong contrast.
cv::Mat SpeckleTexture(int size_px, uint64_t seed);

/// MJCF around `worldbody` and `assets`, with a free body "flyer" that carries the camera "camera.left"; the body's
/// frame is the camera's optical frame. Even light: what is painted white is displayed white, whichever way it faces.
MjModelPtr FlyerModel(const std::string& worldbody, const std::string& assets = "",
                      std::vector<std::pair<std::string, std::vector<unsigned char>>> files = {},
                      const std::string& on_flyer = "");

/// A room with speckled floor, walls and some boxes, about 4 m wide around the origin.
MjModelPtr SpeckledRoom();

/// Pose of the flyer as a function of time in seconds.
using Flight = std::function<Pose(double)>;

/// The record of a flight, with physics steps of 2 ms, from `begin_s` to `end_s`.
MotionRecord RecordFlight(const mjModel* model, const Flight& flight, double begin_s, double end_s);

/// Starts at X_WC and moves with constant twist in its own frame: v m/s, w rad/s.
Flight ConstantTwist(const Pose& X_WC, const Eigen::Vector3d& v, const Eigen::Vector3d& w);

/// The flyer of a FlyerModel at rest at a pose, with kinematics for rendering.
SceneInstant PlaceFlyer(const mjModel* model, mjData* data, const Pose& X_WC);

/// Looks along the world's +x, level.
Pose LookingAlongX(const Eigen::Vector3d& position);

}  // namespace gaitcam
