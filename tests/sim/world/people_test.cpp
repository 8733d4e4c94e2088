/// People as the simulation has them: seen in every instant of an exposure, and felt by nobody.

#include "models/code/people/people.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "models/code/people/person_walk.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/exposure.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

constexpr double kSpeed = 1.2;

/// Crosses the camera's view from right to left, 1.5 m ahead of the origin, and is straight ahead after about 2 s.
PersonOptions Crossing() {
  PersonOptions person;
  person.path = {{1.5, -2}, {1.5, 2}};
  person.speed_m_s = kSpeed;
  return person;
}

Scene With(const std::vector<PersonOptions>& people) {
  Scene scene;
  AddPeople(people, scene);
  return scene;
}

World Standing(const Scene& scene) {
  const Robot robot = ReadRobot("omni_base", kModels);
  return World(robot, scene, PhysicsOptions(), {{"camera.left", Pose()}}, 1);
}

void SimulateUntil(World& world, double until_s) {
  while (world.stamp_ns() < std::llround(until_s * 1e9)) world.Step();
}

TEST(People, TheRobotMovesAsIfNobodyWereThere) {
  const Robot robot = ReadRobot("khr1hv", kModels);
  PhysicsOptions physics;
  physics.mass_noise_ratio = physics.friction_noise_ratio = 0.1;
  Scene scene;
  scene.boxes.emplace_back();  // something to fall on
  scene.boxes[0].X_WB = Pose(RotZ(0.3), {0.2, 0, 0.02});
  scene.boxes[0].size = {0.2, 0.3, 0.04};
  Scene busy = scene;
  PersonOptions onlooker, walker = Crossing();
  onlooker.path = {{0, 0}};  // where the robot is
  onlooker.speed_m_s = 0;
  walker.path = {{0.1, -0.5}, {0.1, 0.5}};
  AddPeople({onlooker, walker}, busy);
  World alone(robot, scene, physics, {{"camera.left", Pose()}}, 4),
      among(robot, busy, physics, {{"camera.left", Pose()}}, 4);
  for (World* world : {&alone, &among}) {
    world->SetState(Pose(RotY(0.3), {0, 0, 0.4}), std::vector<double>(robot.joints.size(), 0.1));
    SimulateUntil(*world, 1);
  }
  ASSERT_EQ(alone.model()->nq, among.model()->nq);
  ASSERT_EQ(alone.model()->nv, among.model()->nv);
  EXPECT_GT(alone.data()->ncon, 0);
  EXPECT_TRUE(std::equal(alone.data()->qpos, alone.data()->qpos + alone.model()->nq, among.data()->qpos));
  EXPECT_TRUE(std::equal(alone.data()->qvel, alone.data()->qvel + alone.model()->nv, among.data()->qvel));
  EXPECT_TRUE(std::equal(alone.data()->sensordata, alone.data()->sensordata + alone.model()->nsensordata,
                         among.data()->sensordata));
}

/// To make it takes longer than all else that a person needs.
TEST(People, ThePictureOfTheirClothesIsMadeOnceForAll) {
  Scene scene = With({Crossing(), Crossing(), Crossing()});
  SceneTexture& cloth = scene.textures[size_t(scene.cloth_texture)];
  int made = 0;
  cloth.make = [&made, make = cloth.make] {
    ++made;
    return make();
  };
  const World world = Standing(scene);
  EXPECT_EQ(made, 1);
}

TEST(People, AreWhereTheyWalkAtAnyInstantOfTheRecord) {
  const Scene scene = With({Crossing()});
  World world = Standing(scene);
  SimulateUntil(world, 1);
  const PersonWalk walk(scene.people[0]);
  const MjDataPtr scratch(mj_makeData(world.model()));
  const int shoe = mj_name2id(world.model(), mjOBJ_BODY, "person0.left_shoe");
  ASSERT_GE(shoe, 0);
  for (const int64_t stamp : {0L, 500000000L, 700300001L, 1000000000L}) {
    world.record().Evaluate(world.model(), stamp, scratch.get());
    const Pose there = walk.At(1e-9 * double(stamp))[size_t(PersonPart::kLeftShoe)];
    EXPECT_EQ(Eigen::Map<const Eigen::Vector3d>(scratch->xpos + 3 * shoe), there.translation);
  }
  // A bystander's film looks at the world's own data.
  const Pose now = walk.At(1)[size_t(PersonPart::kLeftShoe)];
  EXPECT_EQ(Eigen::Map<const Eigen::Vector3d>(world.data()->xpos + 3 * shoe), now.translation);
}

TEST(People, ThoseThatAreSeenCanBePosedWithoutTheOthers) {
  PersonOptions other = Crossing();
  other.path = {{2, 1}, {2, -1}};
  World world = Standing(With({Crossing(), other}));
  SimulateUntil(world, 1);
  const mjModel* model = world.model();
  const MjDataPtr all(mj_makeData(model)), robot(mj_makeData(model));
  const int64_t stamp = 700300001;
  world.record().Evaluate(model, stamp, all.get());
  world.record().EvaluateRobot(model, stamp, robot.get());
  const SceneInstant whole = CaptureInstant(model, *all, 0, stamp);
  SceneInstant part = CaptureInstant(model, *robot, 0, stamp, false);
  const int first = FirstPersonBody(model), seen = first + kPersonParts + 3;
  PoseSeenPeople(model, *world.record().people(), std::vector<int>{0, 1, seen}, part);
  ASSERT_EQ(part.X_WB.size(), whole.X_WB.size());
  const auto apart = [&](int body) {
    const Pose X = part.X_WB[size_t(body)].Inverse() * whole.X_WB[size_t(body)];
    return X.translation.norm() + (X.R() - Eigen::Matrix3d::Identity()).norm();
  };
  EXPECT_EQ(part.X_WC.translation, whole.X_WC.translation);
  for (int body = 0; body < first; ++body) EXPECT_LT(apart(body), 1e-14) << body;  // rounding of the test's own
  EXPECT_LT(apart(seen), 1e-12);  // MuJoCo normalises quaternions once more
  EXPECT_GT(apart(seen + 1), 0.1);
}

/// One frame by a robot that stands, at an instant when the person is in the middle of the view.
struct Shot {
  ExposedFrame frame;
  CameraModel camera = CameraModel::FromHorizontalFov(160, 120, 60);
  double exposure_s = 0.02;

  explicit Shot(const Scene& scene, double stamp_s = 2.3) {
    World world = Standing(scene);
    SimulateUntil(world, stamp_s + exposure_s);
    EglContext gl;
    Renderer renderer(world.model(), {}, world.pictures());
    FilmOptions film;
    film.exposure.exposure_ms = 1e3 * exposure_s;
    ExposingCamera exposing(world.model(), "camera.left", camera, film);
    TruthOptions truth;
    truth.sharp = truth.depth = truth.blur = true;
    frame = exposing.Expose(renderer, world.record(), std::llround(stamp_s * 1e9), truth, RandomStream(1, "noise"));
    middle_s = stamp_s;
  }

  /// The part of the person whose motion fits a pixel's blur vector best, and how far the two are apart, px.
  std::pair<double, PersonPart> NearestPart(const PersonWalk& walk, int u, int v, const Eigen::Vector2d& blur) const {
    const PersonPose open = walk.At(middle_s - exposure_s / 2), middle = walk.At(middle_s),
                     close = walk.At(middle_s + exposure_s / 2);
    const Eigen::Vector3d p_C = double(frame.truth.depth.at<float>(v, u)) * camera.Unproject({double(u), double(v)});
    std::pair<double, PersonPart> best{1e9, PersonPart::kHips};
    for (int part = 0; part < kPersonParts; ++part) {
      const Eigen::Vector3d p_P = middle[part].Inverse() * (frame.truth.X_WC * p_C);
      const auto from = camera.Project(frame.truth.X_WC_open.Inverse() * (open[part] * p_P));
      const auto to = camera.Project(frame.truth.X_WC_close.Inverse() * (close[part] * p_P));
      best = std::min(best, {(*to - *from - blur).norm(), PersonPart(part)});
    }
    return best;
  }

  double middle_s = 0;
};

TEST(People, BlurAlongTheirMotionWhileTheFloorStaysSharp) {
  Scene scene = With({Crossing()});
  const Shot with(scene);
  scene.people.clear();
  const Shot without(scene);
  cv::Mat person = with.frame.truth.depth != without.frame.truth.depth;
  ASSERT_GT(cv::countNonZero(person), 1000);
  const PersonWalk walk(Crossing());
  double sum = 0, worst = 0;
  int chest = 0;
  for (int v = 0; v < person.rows; ++v) {
    for (int u = 0; u < person.cols; ++u) {
      const cv::Vec2f blur = with.frame.truth.blur.at<cv::Vec2f>(v, u);
      const Eigen::Vector2d vector(blur[0], blur[1]);
      if (person.at<uint8_t>(v, u)) {
        const auto [apart, part] = with.NearestPart(walk, u, v, vector);
        worst = std::max(worst, apart);
        if (part != PersonPart::kChest) continue;
        ++chest;
        sum += vector.x() * with.frame.truth.depth.at<float>(v, u);
      } else {
        EXPECT_LT(vector.norm(), 0.02);
      }
    }
  }
  EXPECT_LT(worst, 5e-3);  // px; single precision in depth and vectors
  // In metres, the chest moves to the left as fast as the person walks; it turns a little against the hips.
  const double walking = with.camera.fx * kSpeed * with.exposure_s;
  ASSERT_GT(chest, 100);
  EXPECT_NEAR(sum / chest, -walking, 0.15 * walking);
  EXPECT_GT(with.frame.truth.subframes.size(), without.frame.truth.subframes.size());

  // Edges across the motion are smeared, where the sharp twin's are steep; beyond the person nothing differs.
  cv::Mat blurred, sharp, blurred_x, sharp_x, near_person;
  cv::cvtColor(with.frame.image.pixels, blurred, cv::COLOR_BGR2GRAY);
  cv::cvtColor(with.frame.truth.sharp, sharp, cv::COLOR_BGR2GRAY);
  cv::Scharr(blurred, blurred_x, CV_32F, 1, 0);
  cv::Scharr(sharp, sharp_x, CV_32F, 1, 0);
  cv::dilate(person, near_person, cv::Mat(), {-1, -1}, 3);
  double steepest_blurred = 0, steepest_sharp = 0;
  cv::minMaxLoc(cv::abs(blurred_x), nullptr, &steepest_blurred, nullptr, nullptr, near_person);
  cv::minMaxLoc(cv::abs(sharp_x), nullptr, &steepest_sharp, nullptr, nullptr, near_person);
  EXPECT_LT(steepest_blurred, 0.8 * steepest_sharp);
}

TEST(People, TheSameFrameTwiceAndAnotherAMomentLater) {
  const Scene scene = With({Crossing()});
  const Shot a(scene), b(scene), later(scene, 2.4);
  EXPECT_EQ(cv::norm(a.frame.image.pixels, b.frame.image.pixels, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a.frame.image.pixels, later.frame.image.pixels, cv::NORM_INF), 50);
}

}  // namespace
}  // namespace gaitcam
