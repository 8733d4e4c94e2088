#include "sim/camera/key_picture.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "sim/camera/egl_context.h"
#include "sim/camera/light.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// A speckled room and, fixed to the camera, a speckled plate that fills a quarter of the view.
MjModelPtr RoomWithPlate() {
  const std::string assets =
      "<texture name='t' type='2d' file='speckle.png'/><material name='m' texture='t' texrepeat='2 2' specular='0'/>";
  const std::string wall = "<geom type='box' pos='1.5 0 0' size='2 2 0.001' zaxis='-1 0 0' material='m'/>";
  const std::string plate = "<geom type='box' pos='0.06 0.05 0.3' size='0.06 0.05 0.001' material='m'/>";
  return FlyerModel(wall, assets, {PngFile("speckle.png", SpeckleTexture(256, 3))}, plate);
}

struct SpeckledStage {
  EglContext gl;
  MjModelPtr model;
  MjDataPtr data;
  Renderer renderer;
  Lens lens{SmallCamera()};
  KeyCamera camera{lens};

  explicit SpeckledStage(MjModelPtr m) : model(std::move(m)), data(mj_makeData(model.get())), renderer(model.get()) {}

  SceneInstant MoveTo(const Pose& X_WC) {
    const SceneInstant there = PlaceFlyer(model.get(), data.get(), X_WC);
    renderer.Update(*data);
    return there;
  }

  KeyPicture See(const SceneInstant& at, int finer) {
    KeyPicture key = camera.See(renderer, *data, at, finer, Eigen::Vector2d::Zero());
    camera.Decode(key);
    return key;
  }

  /// CV_8UC3, seen from the middle of the pixels.
  cv::Mat Shear(const KeyPicture& key, const SceneInstant& when) {
    const std::vector<float> weights(120, 1.f);
    const ShearedFrame frame{&when, Eigen::Vector2d::Zero(), weights};
    cv::Mat light(120, 160, CV_32FC4, cv::Scalar::all(0)), colours;
    camera.Add(key, {&frame, 1}, light);
    cv::cvtColor(light, colours, cv::COLOR_BGRA2BGR);
    return EncodeSrgb(colours);
  }
};

/// Median over the pixels of a rectangle, grey levels.
double MedianDifference(const cv::Mat& a, const cv::Mat& b, const cv::Rect& where) {
  cv::Mat difference;
  cv::absdiff(a(where), b(where), difference);
  std::vector<uint8_t> values;
  for (int row = 0; row < difference.rows; ++row) {
    values.insert(values.end(), difference.ptr<uint8_t>(row), difference.ptr<uint8_t>(row) + difference.cols * 3);
  }
  std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// What is computed from the key of one pose is what a key of the other shows of its own instant. Rendering and
// interpolation differ by 2 levels in the median on these speckles, whose contrast between neighbours is 25.
TEST(KeyPicture, ShowsWhatIsSeenFromAnotherPose) {
  SpeckledStage stage(SpeckledRoom());
  const Pose here = LookingAlongX({0, 0, 0.4});
  for (const Pose& step : {Pose(RotY(0.03), {0, 0, 0}), Pose(RotZ(0.05), {0, 0, 0}),
                           Pose(RotX(0.02), Eigen::Vector3d(0.01, 0.005, 0.02))}) {
    const SceneInstant there = stage.MoveTo(here * step);
    const cv::Mat truth = stage.Shear(stage.See(there, 3), there);
    const KeyPicture key = stage.See(stage.MoveTo(here), 3);
    const cv::Rect inside(4, 4, 152, 112);
    EXPECT_LE(MedianDifference(stage.Shear(key, there), truth, inside), 2);
    EXPECT_GE(MedianDifference(stage.Shear(key, key.at), truth, inside), 8);  // unmoved it is another picture
  }
}

TEST(KeyPicture, FollowsEveryBodyByItsOwnMotion) {
  SpeckledStage stage(RoomWithPlate());
  const Pose here = LookingAlongX({0, 0, 0});
  const SceneInstant there = stage.MoveTo(here * Pose(RotY(0.04), {0, 0, 0}));
  const cv::Mat truth = stage.Shear(stage.See(there, 3), there);
  const KeyPicture key = stage.See(stage.MoveTo(here), 3);
  ASSERT_FALSE(key.bodies.empty());
  const cv::Mat sheared = stage.Shear(key, there);
  EXPECT_LE(MedianDifference(sheared, truth, cv::Rect(92, 72, 30, 24)), 2);  // the plate, which rides along
  EXPECT_LE(MedianDifference(sheared, truth, cv::Rect(6, 6, 60, 50)), 2);    // the wall, which does not
}

TEST(KeyPicture, BodiesAndNearnessAreOfTheSameSamples) {
  // A ball that rides along, before a far wall: its outline meets pixels in all ways.
  SpeckledStage stage(FlyerModel("<geom type='box' pos='3 0 0' size='0.001 5 5'/>", "", {},
                                 "<geom type='sphere' pos='0.02 0.01 0.3' size='0.06'/>"));
  for (const int finer : {2, 3, 4}) {
    const KeyPicture key = stage.See(stage.MoveTo(LookingAlongX({0, 0, 0})), finer);
    int ball = 0;
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        EXPECT_EQ(key.bodies.at<int>(v, u) > 0, key.nearness.at<float>(v, u) > 1) << finer << ": " << u << ", " << v;
        ball += key.bodies.at<int>(v, u) > 0;
      }
    }
    EXPECT_GT(ball, 1000);
  }
}

TEST(KeyPicture, RowsOfNoWeightStayDark) {
  SpeckledStage stage(SpeckledRoom());
  const SceneInstant here = stage.MoveTo(LookingAlongX({0, 0, 0.4}));
  const KeyPicture key = stage.See(here, 2);
  std::vector<float> weights(120, 0.f);
  weights[60] = 0.5f;
  const ShearedFrame half{&here, Eigen::Vector2d::Zero(), weights};
  cv::Mat light(120, 160, CV_32FC4, cv::Scalar::all(0)), whole = light.clone();
  stage.camera.Add(key, {&half, 1}, light);
  const std::vector<float> ones(120, 1.f);
  const ShearedFrame full{&here, Eigen::Vector2d::Zero(), ones};
  stage.camera.Add(key, {&full, 1}, whole);
  EXPECT_EQ(cv::norm(light.rowRange(0, 60), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(light.rowRange(61, 120), cv::NORM_INF), 0);
  EXPECT_LE(cv::norm(light.row(60), 0.5 * whole.row(60), cv::NORM_INF), 1e-6);  // single precision
}

}  // namespace
}  // namespace gaitcam
