#include "scenarios/code/runs/pasted_robots.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/renderer.h"
#include "sim/walking/walker.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

constexpr int kSides = 8;
constexpr int kPicture_px = 480;
constexpr double kDistance_m = 1.5;

/// An empty floor in the light of a scene.
Scene Studio(const Scene& scene) {
  Scene studio;
  studio.lights = scene.lights;
  studio.ambient = scene.ambient;
  studio.ambient_rgb = scene.ambient_rgb;
  return studio;
}

RobotPicture Cropped(const cv::Mat& bgr, const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  GAITCAM_ASSERT(box.area() > 0);
  return {bgr(box).clone(), mask(box).clone(), 0.5 * (bgr.rows - 1) - box.y, 0.5 * (bgr.cols - 1) - box.x};
}

struct Pasting {
  const RobotPicture* picture;
  double column;  ///< Where the robot's middle goes.
};

/// Draws the robots at a scale, later ones in front. @returns the mask, CV_8UC1.
cv::Mat Draw(const std::vector<Pasting>& pastings, double scale, double horizon_row, cv::Mat& image) {
  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8UC1);
  for (const Pasting& p : pastings) {
    // Shrunk first, as a warp alone would not average pixels.
    const double shrink = std::min(1.0, scale), rest = scale / shrink;
    cv::Mat bgr, alpha;
    cv::resize(p.picture->bgr, bgr, {}, shrink, shrink, cv::INTER_AREA);
    cv::resize(p.picture->mask, alpha, {}, shrink, shrink, cv::INTER_AREA);
    const cv::Mat move = (cv::Mat_<double>(2, 3) << rest, 0, p.column - scale * p.picture->middle_col, 0, rest,
                          horizon_row - scale * p.picture->eye_row);
    cv::Mat placed, opacity;
    cv::warpAffine(bgr, placed, move, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    cv::warpAffine(alpha, opacity, move, image.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const double a = opacity.at<uchar>(v, u) / 255.0;
        if (a == 0) continue;
        auto& pixel = image.at<cv::Vec3b>(v, u);
        const cv::Vec3b& robot = placed.at<cv::Vec3b>(v, u);
        for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<uchar>((1 - a) * pixel[c] + a * robot[c]);
        mask.at<uchar>(v, u) = std::max(mask.at<uchar>(v, u), opacity.at<uchar>(v, u));
      }
    }
  }
  return mask;
}

}  // namespace

std::vector<RobotPicture> PictureRobot(const Robot& robot, const Scene& scene, const GaitOptions& gait,
                                       const RendererChoice& choice, double eye_height_m) {
  const EglContext gl(choice);
  World world(robot, Studio(scene), {}, {}, 0);
  if (robot.kind == Robot::Kind::kHumanoid) {
    PathOptions stand;
    stand.kind = PathKind::kStand;
    const auto walker = MakeWalker(robot, world.nominal_model(), gait, stand, {}, Pose());
    world.SetState(walker->InitialRoot(), walker->InitialJoints());
  }
  Renderer renderer(world.model());
  const CameraModel camera = CameraModel::FromHorizontalFov(kPicture_px, kPicture_px, 40);
  std::vector<RobotPicture> pictures;
  for (int side = 0; side < kSides; ++side) {
    const Pose X_WV = LookAt({0, 0, eye_height_m}, kDistance_m, side * 2 * std::numbers::pi / kSides, 0);
    const cv::Mat bgr = renderer.Picture(*world.data(), X_WV, camera, 2);
    renderer.Draw(*world.data(), X_WV, camera, Eigen::Vector2d::Zero(), 1, true);
    pictures.push_back(Cropped(bgr, renderer.Bodies(*world.data()) > 0));
  }
  return pictures;
}

PastedImage PasteRobots(const cv::Mat& image, const std::vector<RobotPicture>& pictures, const CameraModel& camera,
                        const Eigen::Vector3d& up_C, const CylinderProjection& projection, double ratio,
                        RandomStream& random) {
  GAITCAM_ASSERT(!pictures.empty() && image.type() == CV_8UC3);
  const auto horizon = camera.Project(LevelAxes(up_C).forward);
  const double horizon_row = horizon ? horizon->y() : camera.cy;
  std::vector<Pasting> pastings;
  for (int i = std::max(1, int(std::lround(10 * ratio))); i > 0; --i) {
    pastings.push_back({&pictures[size_t(random.Index(int(pictures.size())))], random.Uniform(0.1, 0.9) * image.cols});
  }
  const auto covered = [&](double scale, cv::Mat& drawn) {
    drawn = image.clone();
    return cv::mean(projection.ProjectView(Draw(pastings, scale, horizon_row, drawn)))[0] / 255;
  };
  PastedImage pasted;
  double low = 0.02, high = 8;
  for (int i = 0; i < 14; ++i) {
    const double scale = std::sqrt(low * high);
    pasted.covered_ratio = covered(scale, pasted.image);
    (pasted.covered_ratio < ratio ? low : high) = scale;
  }
  return pasted;
}

}  // namespace gaitcam
