#include "sim/camera/occlusion.h"

#include <gtest/gtest.h>

#include "sim/camera/egl_context.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// A white plate one metre away before a black wall at three.
struct PlateStage {
  EglContext gl;
  MjModelPtr model = FlyerModel(
      "<geom type='box' pos='1 0 0' size='0.001 0.2 0.2' rgba='1 1 1 1'/>"
      "<geom type='box' pos='3 0 0' size='0.001 5 5' rgba='0 0 0 1'/>");
  MjDataPtr data{mj_makeData(model.get())};
  Renderer renderer{model.get()};
  Lens lens{SmallCamera()};
  KeyCamera camera{lens};

  SceneInstant At(const Pose& X_WC) { return PlaceFlyer(model.get(), data.get(), X_WC); }

  /// Of an exposure between two poses, seen from the origin.
  GreyError Error(const Pose& open, const Pose& close) {
    const SceneInstant before = At(open), after = At(close), middle = At(LookingAlongX({0, 0, 0}));
    renderer.Update(*data);
    cv::Mat depth;
    const KeyPicture key = camera.See(renderer, *data, middle, 2, Eigen::Vector2d::Zero(), &depth);
    return OcclusionError(key, lens.rays(), depth, before, after);
  }
};

TEST(OcclusionError, IsNothingWhileTheCameraOnlyTurns) {
  PlateStage stage;
  const Pose X = LookingAlongX({0, 0, 0});
  const GreyError error = stage.Error(X * Pose(RotY(-0.05), {0, 0, 0}), X * Pose(RotY(0.05), {0, 0, 0}));
  EXPECT_LE(error.rms, 1e-4);  // single precision of the depths
  EXPECT_LE(error.p99_9, 1e-3);
}

TEST(OcclusionError, GrowsWithTheStripThatIsUncovered) {
  PlateStage stage;
  const auto rms = [&](double aside_m) {
    return stage.Error(LookingAlongX({0, -aside_m, 0}), LookingAlongX({0, aside_m, 0})).rms;
  };
  // One edge's error goes with the strip until the plate's path is a pixel long; from there on with the square root of
  // it, as the same strip is spread over more pixels, each with less.
  const double small = rms(0.0005), twice = rms(0.001);
  EXPECT_GT(small, 0);
  EXPECT_NEAR(twice / small, 2, 0.1);
  EXPECT_GT(rms(0.02), twice);
}

TEST(OcclusionError, KnowsHowWrongAStripIs) {
  PlateStage stage;
  // The plate moves by 2 * 0.0018 * 138.6 = 0.5 px, the wall by a third of it: from the middle to either end they move
  // 0.167 px against each other, on average over the exposure 0.083 px, times 255 levels.
  const GreyError error = stage.Error(LookingAlongX({0, -0.0018, 0}), LookingAlongX({0, 0.0018, 0}));
  // Two vertical edges of 55 px each, a hundredth of the image's rows and columns: beyond the worst thousandth of
  // pixels.
  EXPECT_NEAR(error.p99_9, 255 * 0.083, 4);
}

}  // namespace
}  // namespace gaitcam
