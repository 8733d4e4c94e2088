/// What a renderer leaves out or tells apart when it sees many people.

#include <gtest/gtest.h>

#include <set>

#include "sim/camera/egl_context.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"
#include "tests/data_folder.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// People in rows along x, each of other colours, who stand or walk on.
Scene CrowdScene(int rows, int abreast, double apart_m) {
  std::vector<PersonOptions> people;
  for (int i = 0; i < rows * abreast; ++i) {
    PersonOptions person;
    const double x = 1.2 + apart_m * (i / abreast), y = apart_m * (i % abreast - 0.5 * (abreast - 1));
    person.path = {{x, y}, {x + 1, y + 0.3}};
    person.start_s = -0.1 * i;
    const double tone = 0.2 + 0.7 * i / (rows * abreast);
    person.trousers_rgb = {tone, 1 - tone, 0.5};
    person.shoes_rgb = {1 - tone, 0.5, tone};
    people.push_back(person);
  }
  Scene scene;
  AddPeople(people, scene);
  return scene;
}

struct CrowdStage {
  EglContext gl;
  MjcfBundle bundle;
  MjModelPtr model;
  MjDataPtr data;

  explicit CrowdStage(const Scene& scene)
      : bundle(BuildMjcf(ReadRobot("omni_base", TestData() / "models"), scene, {}, {{"camera.left", Pose()}})),
        model(CompileMjcf(bundle, "crowd")),
        data(mj_makeData(model.get())) {
    const std::vector<PersonWalk> people(scene.people.begin(), scene.people.end());
    PosePeople(model.get(), people, 700000000, data.get());
    mj_forward(model.get(), data.get());
  }
};

const CameraModel kCrowdView = CameraModel::FromHorizontalFov(320, 240, 60);

TEST(Crowd, LeavingOutWhoIsHiddenChangesNothing) {
  const CrowdStage stage(CrowdScene(6, 6, 0.3));
  RendererOptions keep_all;  // with shadows on; no light casts any here
  keep_all.shadows = true;
  Renderer some(stage.model.get(), {}, stage.bundle.pictures), all(stage.model.get(), keep_all, stage.bundle.pictures);
  // From afar, among them and from within somebody; near the floor, as high as heads, and askew.
  int left_out = 0;
  for (const Pose& X_WC :
       {LookingAlongX({0, 0, 0.35}), LookingAlongX({-1, 0.3, 1.2}), LookingAlongX({1.35, 0.02, 0.3}),
        LookingAlongX({1.2, 0.15, 0.6}) * Pose(RotZ(0.6), {0, 0, 0}),
        LookingAlongX({0.3, 0.5, 0.2}) * Pose(RotY(0.4), {0, 0, 0}), LookAt({2, 0, 0.8}, 3, 1, -0.7)}) {
    const cv::Mat a = some.Picture(*stage.data, X_WC, kCrowdView, 3), b = all.Picture(*stage.data, X_WC, kCrowdView, 3);
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0) << X_WC.translation.transpose();
    left_out += all.drawn() - some.drawn();
  }
  some.Picture(*stage.data, LookingAlongX({0, 0, 0.35}), kCrowdView);
  EXPECT_LT(some.drawn(), all.drawn() / 2);
  EXPECT_GT(left_out, 2000);
}

// Beside the stencil's labels there is a slower way, which is taken where anything moving is transparent.
TEST(Crowd, ManyBodiesAreToldApartAsFew) {
  const CrowdStage stage(CrowdScene(6, 6, 0.45));
  const Pose above = LookAt({2.3, 0, 0.8}, 4.5, 0, -0.9);
  std::vector<cv::Mat> labels;
  for (const float opacity : {1.f, 0.9f}) {
    stage.model->geom_rgba[4 * (stage.model->ngeom - 1) + 3] = opacity;
    Renderer renderer(stage.model.get(), {}, stage.bundle.pictures);
    renderer.Update(*stage.data);
    renderer.Draw(*stage.data, above, kCrowdView, Eigen::Vector2d::Zero(), 1, true);
    labels.push_back(renderer.Bodies(*stage.data));
  }
  const std::set<int> seen(labels[0].begin<int>(), labels[0].end<int>());
  EXPECT_GT(seen.size(), 260u);  // more than a stencil can hold
  EXPECT_EQ(cv::norm(labels[0], labels[1], cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gaitcam
