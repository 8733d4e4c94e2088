/// Scenes as cameras see them: textures the right way round and where they should be, well-exposed, with enough to
/// track.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

/// Looks level along `yaw` (0: along +x), then down by `pitch`, rad.
Pose Look(const Eigen::Vector3d& position, double yaw, double pitch) {
  Eigen::Matrix3d R_forward;  // columns: camera x right = -y, y down = -z, z forward = +x
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Pose(Eigen::Matrix3d(RotZ(yaw) * RotY(pitch) * R_forward), position);
}

/// A scene alone: the robot that a world needs stands far beyond what is seen.
class SceneViewer {
 public:
  explicit SceneViewer(const Scene& scene)
      : world_(ReadRobot("omni_base", kModels), scene, PhysicsOptions{}, {}, 1),
        renderer_(world_.model(), {}, world_.pictures()) {
    world_.SetState(Pose(Eigen::Quaterniond::Identity(), {500, 500, 0}),
                    std::vector<double>(world_.robot().joints.size(), 0.0));
    mj_forward(world_.model(), world_.data());
  }

  cv::Mat Grey(const Pose& X_WC, const CameraModel& camera) {
    cv::Mat grey;
    cv::cvtColor(Color(X_WC, camera), grey, cv::COLOR_BGR2GRAY);
    return grey;
  }
  cv::Mat Color(const Pose& X_WC, const CameraModel& camera) {
    return renderer_.Picture(*world_.data(), X_WC, camera, 2);
  }

 private:
  EglContext context_;
  World world_;
  Renderer renderer_;
};

/// Straight down from 0.6 m the camera sees what the floor's image shows around there.
void ExpectFloorAsInItsImage(const std::string& name, double x, double y) {
  const Scene scene = ReadScene(name, kModels);
  SceneViewer viewer(scene);
  CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  constexpr double kHeight = 0.6;
  const double px_per_m = camera.fx / kHeight;
  // Straight down; the picture's top looks along +x, so its right is -y.
  const cv::Mat seen = viewer.Grey(Look({x, y, kHeight}, 0, M_PI / 2), camera);
  cv::Mat floor, turned;
  cv::cvtColor(FloorImage(scene, px_per_m), floor, cv::COLOR_BGR2GRAY);
  // FloorImage has x to the right and y up. Turned counterclockwise, its top is +x and its right is -y.
  cv::rotate(floor, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  const double column = (scene.floor_max.y() - y) * px_per_m, row = (scene.floor_max.x() - x) * px_per_m;
  const cv::Rect around(int(std::lround(column - 160)) - 8, int(std::lround(row - 120)) - 8, 320 + 16, 240 + 16);
  ASSERT_EQ(around & cv::Rect({0, 0}, turned.size()), around);
  cv::Mat score;
  cv::matchTemplate(turned(around), seen, score, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
  EXPECT_GT(best, 0.9);  // the same picture, but for the renderer's filtering
  // Rounding of the cut-out is half a pixel in each direction.
  EXPECT_NEAR(at.x, 8, 1);
  EXPECT_NEAR(at.y, 8, 1);
}

TEST(SceneView, TheFloorLiesWhereItsTrueImageSays) { ExpectFloorAsInItsImage("lab", 2.0, -2.3); }

TEST(SceneView, ThePrintsOnATableLieWhereItsTrueImageSays) {
  ExpectFloorAsInItsImage("tabletop", 0.5, -0.3);
  ExpectFloorAsInItsImage("tabletop", -0.6, 0.6);
}

TEST(SceneView, PicturesAreUprightAndNotMirrored) {
  cv::Mat picture(64, 64, CV_8UC3, cv::Scalar(0, 0, 0));  // black, but: top left red, top right green, bottom left blue
  picture(cv::Rect(0, 0, 32, 32)).setTo(cv::Scalar(0, 0, 255));
  picture(cv::Rect(32, 0, 32, 32)).setTo(cv::Scalar(0, 255, 0));
  picture(cv::Rect(0, 32, 32, 32)).setTo(cv::Scalar(255, 0, 0));
  const TemporaryFolder folder;
  cv::imwrite((folder.path() / "corners.png").string(), picture);
  const std::filesystem::path file =
      folder.Write("scene_view.yaml",
                   "floor: {texture: {kind: paint, px_per_m: 32}}\n"
                   "textures: {corners: {kind: image, file: corners.png}}\n"
                   "ambient: 0.8\n"
                   "posters:\n"
                   "  - {at: [2, 0, 0.5], facing_deg: 180, size: [1, 1], texture: corners}\n"
                   "  - {at: [0, 0, 0.1], lies: true, facing_deg: 90, size: [1, 1], texture: corners}\n"
                   "boxes: [{at: [0, -3, 0.5], size: [1, 1, 1], texture: corners}]\n");
  const Scene scene = ReadScene(file.string(), kModels);
  SceneViewer viewer(scene);
  const CameraModel camera = CameraModel::FromHorizontalFov(200, 200, 60);
  const auto expect_corners = [&](const Pose& X_WC, const char* what) {
    const cv::Mat view = viewer.Color(X_WC, camera);
    const auto bright = [&](int x, int y, int channel) { return view.at<cv::Vec3b>(y, x)[channel] > 120; };
    constexpr int kLow = 70, kHigh = 130;
    EXPECT_TRUE(bright(kLow, kLow, 2) && !bright(kLow, kLow, 1)) << what << ": red is not at the top left";
    EXPECT_TRUE(bright(kHigh, kLow, 1) && !bright(kHigh, kLow, 2)) << what << ": green is not at the top right";
    EXPECT_TRUE(bright(kLow, kHigh, 0) && !bright(kLow, kHigh, 2)) << what << ": blue is not at the bottom left";
    EXPECT_FALSE(bright(kHigh, kHigh, 0) || bright(kHigh, kHigh, 1) || bright(kHigh, kHigh, 2)) << what;
  };
  expect_corners(Look({0.6, 0, 0.5}, 0, 0), "poster");
  expect_corners(Look({0, 0, 1.5}, M_PI / 2, M_PI / 2), "print, seen with its upper edge up");
  for (const double yaw : {0.0, M_PI / 2, M_PI, -M_PI / 2}) {
    const Eigen::Vector3d away(std::cos(yaw), std::sin(yaw), 0);
    expect_corners(Look(Eigen::Vector3d(0, -3, 0.5) - 1.9 * away, yaw, 0), "side of a box");
  }
  expect_corners(Look({0, -3, 2.4}, M_PI / 2, M_PI / 2), "top of a box, seen with +y up");
}

TEST(SceneView, ShippedScenesAreWellExposedAndOfferFeaturesFromTheirStart) {
  std::map<std::string, int> features;
  const CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  for (const std::string& name : ListScenes(kModels)) {
    const Scene scene = ReadScene(name, kModels);
    SceneViewer viewer(scene);
    for (const double turn : {0.0, 0.7, -0.7}) {
      const cv::Mat view =
          viewer.Grey(Look({scene.start.x(), scene.start.y(), 0.35}, scene.start.z() + turn, 0.2), camera);
      const double pixels = double(view.total()), mean = cv::mean(view)[0];
      EXPECT_GT(mean, 70) << name;   // display values: neither gloomy
      EXPECT_LT(mean, 190) << name;  // nor glaring
      EXPECT_LT(cv::countNonZero(view >= 250) / pixels, 0.01) << name;
      EXPECT_LT(cv::countNonZero(view <= 8) / pixels, 0.02) << name;
      std::vector<cv::KeyPoint> points;
      cv::SIFT::create()->detect(view, points);
      features[name] += int(points.size());
    }
    RecordProperty(name + "_sift", features[name] / 3);
    if (name != "plain") {
      EXPECT_GT(features[name] / 3, 100) << name;
    }
  }
  EXPECT_LT(features["plain"], features["lab"] / 3);  // the hard case
  EXPECT_GT(features["plain"], 0);
}

}  // namespace
}  // namespace gaitcam
