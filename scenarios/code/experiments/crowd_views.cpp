#include "scenarios/code/experiments/crowd_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "models/code/textures/texture.h"
#include "scenarios/code/files/folders.h"
#include "sim/camera/egl_context.h"
#include "sim/camera/exposure.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

constexpr double kAbove_m = 50;      // the robot hangs so far above its camera, where nobody sees it
constexpr double kBegin_s = 100;     // of a pair: people are on their way by then
constexpr double kFree_m = 0.4;      // around a camera
constexpr double kFromPeople_m = 1;  // between a camera and the nearest person
constexpr double kNear_m = 1.5;      // half of a picture shows what is farther
constexpr double kTurnAside = 0.5;   // rad
constexpr int kMaxAttempts = 500;
constexpr int kThingTextures = 6;

int Clamped(double value, int size) { return std::clamp(int(std::lround(value)), 0, size - 1); }

bool Within(const MovedThing& thing, const Pose& X_WB, const Eigen::Vector3d& p_W) {
  constexpr double kMargin_m = 0.01;
  const Eigen::Vector3d p_B = X_WB.Inverse() * p_W;
  return ((p_B.cwiseAbs() - 0.5 * thing.size).array() < kMargin_m).all();
}

/// Level, looking along the world's x when yaw is 0.
Pose CameraAt(const Eigen::Vector3d& position, double yaw) {
  Eigen::Matrix3d R_BC;  // x right, y down, z forward
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Pose(RotZ(yaw), position) * Pose(R_BC, Eigen::Vector3d(0, 0, 0));
}

Eigen::Vector3d Normal3(RandomStream& random, double sigma) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.Normal(0, sigma);
  return v;
}

Eigen::Vector3d Colour(RandomStream& random) {
  Eigen::Vector3d rgb;
  for (double& x : rgb) x = random.Uniform();
  return rgb;
}

/// Anywhere on the floor.
Eigen::Vector2d DrawSpot(const Scene& scene, RandomStream& random) {
  const double x = random.Uniform(scene.floor_min.x(), scene.floor_max.x());
  return {x, random.Uniform(scene.floor_min.y(), scene.floor_max.y())};
}

PersonOptions DrawPerson(const Scene& scene, double standing, RandomStream& random) {
  PersonOptions person;
  person.path = {DrawSpot(scene, random)};
  person.facing_deg = random.Uniform(-180, 180);
  if (random.Uniform() < standing) {
    person.speed_m_s = 0;
    return person;
  }
  person.speed_m_s = random.Uniform(0.8, 1.4);
  person.repeat = true;
  person.start_s = random.Uniform(0, 20);
  do person.path.resize(1);
  while (person.path.push_back(DrawSpot(scene, random)), (person.path[1] - person.path[0]).norm() < 2);
  return person;
}

/// How somebody looks. Paths are drawn anew for each pair.
PersonOptions Dressed(PersonOptions person, RandomStream& random) {
  person.height_m = random.Uniform(1.5, 1.95);
  person.trousers_rgb = Colour(random);
  person.top_rgb = Colour(random);
  person.hair_rgb = 0.5 * Colour(random);
  person.seed = random.Bits() % 1000;
  return person;
}

/// Boxes of different pictures at the origin.
std::vector<SceneBox> DrawThings(int count, uint64_t seed, Scene& scene) {
  RandomStream random(seed, "crowd.things");
  if (int(scene.textures.size()) + kThingTextures > kMaxSceneTextures)
    throw BadInput("scene " + scene.name + ": it has no room for textures of moved things; expected at most " +
                   std::to_string(kMaxSceneTextures - kThingTextures) + " of its own");
  const int first = int(scene.textures.size());
  for (int i = 0; i < kThingTextures; ++i) {
    TextureOptions options;
    options.kind = std::array{"poster", "dead_leaves", "cardboard"}[size_t(i % 3)];
    options.seed = 7000 + 10 * seed + uint64_t(i);
    options = CompleteTexture(options);
    scene.textures.push_back(
        {"thing" + std::to_string(i), TextureSize(options), [options] { return MakeTexture(options); }});
  }
  std::vector<SceneBox> things;
  for (int i = 0; i < count; ++i) {
    SceneBox box;
    box.name = "thing";
    for (double& edge : box.size) edge = random.Uniform(0.3, 0.8);
    box.texture = first + i % kThingTextures;
    box.collides = false;
    things.push_back(box);
  }
  return things;
}

/// Whether something stands within kFree_m of a place at the camera's height.
bool IsFree(const Scene& scene, const Eigen::Vector3d& place) {
  for (const SceneBox& box : scene.boxes) {
    const Eigen::Vector3d beside = ((box.X_WB.Inverse() * place).cwiseAbs() - 0.5 * box.size).cwiseMax(0);
    if (beside.norm() < kFree_m) return false;
  }
  return (place.head<2>().array() > scene.floor_min.array() + kFree_m).all() &&
         (place.head<2>().array() < scene.floor_max.array() - kFree_m).all();
}

}  // namespace

bool PairTruth::OnMover(const CrowdView& view, const Eigen::Vector2d& pixel, bool second) const {
  const int x = Clamped(pixel.x(), view.depth.cols), y = Clamped(pixel.y(), view.depth.rows);
  if (view.on_people.at<uchar>(y, x) != 0) return true;
  const float z = view.depth.at<float>(y, x);
  if (!(z > 0)) return false;
  const Eigen::Vector3d p_W = view.X_WC * Eigen::Vector3d(double(z) * pair_.camera.Unproject(pixel));
  return std::any_of(pair_.things.begin(), pair_.things.end(),
                     [&](const MovedThing& thing) { return Within(thing, second ? thing.X_WB_b : thing.X_WB_a, p_W); });
}

double PairTruth::Error(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
  const Pose X_BA = pair_.b.X_WC.Inverse() * pair_.a.X_WC;
  const Eigen::Vector3d ray = pair_.camera.Unproject(a);
  double least = std::numeric_limits<double>::infinity();
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const Eigen::Vector2d beside = a + Eigen::Vector2d(dx, dy);
      if (OnMover(pair_.a, beside, false)) continue;
      const float z =
          pair_.a.depth.at<float>(Clamped(beside.y(), pair_.a.depth.rows), Clamped(beside.x(), pair_.a.depth.cols));
      // What is nowhere lies infinitely far away.
      const Eigen::Vector3d p_B = z > 0 ? X_BA * Eigen::Vector3d(double(z) * ray) : X_BA.rotation * ray;
      const auto seen = pair_.camera.Project(p_B);
      if (seen) least = std::min(least, (*seen - b).norm());
    }
  return least;
}

MatchTruth PairTruth::Of(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
  if (OnMover(pair_.a, a, false) || OnMover(pair_.b, b, true)) return MatchTruth::kMover;
  return Error(a, b) <= right_px_ ? MatchTruth::kRight : MatchTruth::kWrong;
}

struct CrowdStage::Parts {
  CrowdOptions options;
  uint64_t seed;
  Scene scene;
  std::vector<SceneBox> things;
  std::vector<std::pair<int, Pose>> thing_geoms;  ///< Of the model, and in their boxes' frames.
  CameraModel camera;
  EglContext gl;
  MjcfBundle bundle;
  MjModelPtr model;
  MjDataPtr data;
  Pose X_RC;  ///< Camera in the frame of the robot's root.
  std::optional<Renderer> renderer;
  std::optional<ExposingCamera> film;
  std::shared_ptr<std::vector<PersonWalk>> people = std::make_shared<std::vector<PersonWalk>>();

  Parts(const CrowdOptions& options, uint64_t seed);
  Pose DrawPlace(RandomStream& random) const;
  std::vector<PersonWalk> DrawPeople(const std::vector<StampedPose>& cameras, RandomStream& random) const;
  std::vector<MovedThing> PutThings(const Pose& X_WC, RandomStream& random) const;
  void FindThings();
  void Place(const std::vector<MovedThing>& moved, bool second);
  std::vector<double> Configuration(const Pose& X_WC) const;
  Pose DrawStep(RandomStream& random) const;
  CrowdView View(const StampedPose& at, RandomStream& random, const std::string& name);
  static int64_t Stamp(double time_s) { return int64_t(std::llround(1e9 * time_s)); }
};

CrowdStage::Parts::Parts(const CrowdOptions& options_in, uint64_t seed_in)
    : options(options_in),
      seed(seed_in),
      camera(CameraModel::FromHorizontalFov(options.width_px, options.height_px, options.hfov_deg)) {
  SceneVariation variation;
  variation.seed = seed;
  scene = ReadVariedScene(options.scene, ModelsFolder(), variation);
  things = DrawThings(options.things, seed, scene);
  RandomStream looks(seed, "crowd.looks");
  const Eigen::Vector2d extent = scene.floor_max - scene.floor_min;
  std::vector<PersonOptions> dressed;
  const int count = int(std::lround(options.people_per_100_m2 * extent.x() * extent.y() / 100));
  for (int i = 0; i < count; ++i) dressed.push_back(Dressed(DrawPerson(scene, 0, looks), looks));
  AddPeople(dressed, scene);
  Scene filled = scene;
  filled.boxes.insert(filled.boxes.end(), things.begin(), things.end());
  bundle = BuildMjcf(ReadRobot("khr1hv", ModelsFolder()), filled, {},
                     {{"camera.left", Pose(Eigen::Matrix3d::Identity(), {0, kAbove_m, 0})}});
  model = CompileMjcf(bundle, scene.name);
  FindThings();
  data = MjDataPtr(mj_makeData(model.get()));
  mj_forward(model.get(), data.get());
  const int root = model->jnt_bodyid[0];
  const Eigen::Quaterniond q(data->xquat[4 * root], data->xquat[4 * root + 1], data->xquat[4 * root + 2],
                             data->xquat[4 * root + 3]);
  const Pose X_WR(q, Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * root));
  X_RC = X_WR.Inverse() * CameraPose(*data, FindCamera(model.get(), "camera.left"));
  renderer.emplace(model.get(), RendererOptions(), bundle.pictures);
  FilmOptions film_options;
  film_options.exposure.exposure_ms = options.exposure_ms;
  film_options.grey = true;
  film_options.light_level = scene.light;
  film.emplace(model.get(), "camera.left", camera, film_options);
}

Pose CrowdStage::Parts::DrawPlace(RandomStream& random) const {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    const Eigen::Vector2d spot = DrawSpot(scene, random);
    const Eigen::Vector3d place(spot.x(), spot.y(), random.Uniform(0.5, 1.6));
    const Pose X_WC = CameraAt(place, random.Uniform(-std::numbers::pi, std::numbers::pi));
    if (IsFree(scene, place)) return X_WC;
  }
  throw BadInput("scene " + scene.name + ": a camera finds no free place in it; expected a scene with free floor");
}

std::vector<PersonWalk> CrowdStage::Parts::DrawPeople(const std::vector<StampedPose>& cameras,
                                                      RandomStream& random) const {
  const auto in_the_way = [&](const PersonWalk& walk) {
    return std::any_of(cameras.begin(), cameras.end(), [&](const StampedPose& at) {
      const Pose hips = walk.At(1e-9 * double(at.stamp_ns))[size_t(PersonPart::kHips)];
      return (hips.translation - at.pose.translation).head<2>().norm() < kFromPeople_m;
    });
  };
  std::vector<PersonWalk> walks;
  for (const PersonOptions& looks : scene.people) {
    std::optional<PersonWalk> walk;
    for (int attempt = 0; attempt < kMaxAttempts && (!walk || in_the_way(*walk)); ++attempt) {
      PersonOptions person = DrawPerson(scene, options.standing, random);
      person.height_m = looks.height_m;
      walk.emplace(person);
    }
    walks.push_back(*walk);
  }
  return walks;
}

/// Before the first camera, and elsewhere for the second view.
std::vector<MovedThing> CrowdStage::Parts::PutThings(const Pose& X_WC, RandomStream& random) const {
  std::vector<MovedThing> moved;
  const Eigen::Vector3d ahead = X_WC.R().col(2);
  const double yaw = std::atan2(ahead.y(), ahead.x());
  for (const SceneBox& thing : things) {
    const auto stand = [&](const Eigen::Vector2d& at) {
      return Pose(RotZ(random.Uniform(-std::numbers::pi, std::numbers::pi)), {at.x(), at.y(), 0.5 * thing.size.z()});
    };
    const double bearing = yaw + random.Uniform(-0.5, 0.5), distance_m = random.Uniform(1.8, 6);
    const Eigen::Vector2d first =
        X_WC.translation.head<2>() + distance_m * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    const double way = random.Uniform(-std::numbers::pi, std::numbers::pi), far_m = random.Uniform(0.3, 1.2);
    const Eigen::Vector2d then = first + far_m * Eigen::Vector2d(std::cos(way), std::sin(way));
    moved.push_back({thing.size, stand(first), stand(then)});
  }
  return moved;
}

/// Their meshes were compiled at the origin, in frames of MuJoCo's own choice.
void CrowdStage::Parts::FindThings() {
  for (size_t i = 0; i < things.size(); ++i) {
    const std::string name = "box" + std::to_string(scene.boxes.size() + i) + "_picture";
    const int geom = mj_name2id(model.get(), mjOBJ_GEOM, name.c_str());
    GAITCAM_ASSERT(geom >= 0);
    const double* q = model->geom_quat + 4 * geom;
    thing_geoms.push_back({geom, Pose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
                                      Eigen::Map<const Eigen::Vector3d>(model->geom_pos + 3 * geom))});
  }
}

void CrowdStage::Parts::Place(const std::vector<MovedThing>& moved, bool second) {
  for (size_t i = 0; i < moved.size(); ++i) {
    const auto& [geom, X_BG] = thing_geoms[i];
    const Pose X_WG = (second ? moved[i].X_WB_b : moved[i].X_WB_a) * X_BG;
    const Eigen::Quaterniond& q = X_WG.rotation;
    const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
    std::copy(wxyz, wxyz + 4, model->geom_quat + 4 * geom);
    std::copy(X_WG.translation.data(), X_WG.translation.data() + 3, model->geom_pos + 3 * geom);
  }
}

std::vector<double> CrowdStage::Parts::Configuration(const Pose& X_WC) const {
  std::vector<double> qpos(model->qpos0, model->qpos0 + model->nq);
  const Pose X_WR = X_WC * X_RC.Inverse();
  const Eigen::Quaterniond& q = X_WR.rotation;
  const double root[] = {X_WR.translation.x(), X_WR.translation.y(), X_WR.translation.z(), q.w(), q.x(), q.y(), q.z()};
  std::copy(root, root + 7, qpos.begin());
  return qpos;
}

/// From one view to the next.
Pose CrowdStage::Parts::DrawStep(RandomStream& random) const {
  const double way = random.Uniform(-45, 45) * kRadPerDeg;
  const double step_m = random.Uniform(options.least_step_m, options.most_step_m);
  const double x = random.Normal(0, options.tilt_deg), y = random.Normal(0, options.turn_deg);
  const double z = random.Normal(0, options.tilt_deg);
  return {ExpSo3(kRadPerDeg * Eigen::Vector3d(x, y, z)), step_m * Eigen::Vector3d(std::sin(way), 0, std::cos(way))};
}

CrowdView CrowdStage::Parts::View(const StampedPose& at, RandomStream& random, const std::string& name) {
  const Eigen::Vector3d rate_rad_s = Normal3(random, options.rate_deg_s * kRadPerDeg);
  const RandomStream noise(seed, "crowd.noise." + name);
  constexpr double kStep_s = 0.002;
  const int half = int(std::ceil(0.5e-3 * options.exposure_ms / kStep_s)) + 1;
  MotionRecord record;
  record.SetPeople(people);
  std::vector<double> before, velocity(size_t(model->nv), 0);
  for (int i = -half; i <= half; ++i) {
    const Pose turned = at.pose * Pose(ExpSo3(i * kStep_s * rate_rad_s), {0, 0, 0});
    std::vector<double> now = Configuration(turned);
    if (!before.empty()) mj_differentiatePos(model.get(), velocity.data(), kStep_s, before.data(), now.data());
    record.Append({at.stamp_ns + int64_t(std::llround(i * kStep_s * 1e9)), now, velocity});
    before = std::move(now);
  }
  const LatentFrame latent = film->Film(*renderer, record, at.stamp_ns, {false, true, false}, noise);
  CrowdView view;
  view.depth = latent.depth.clone();
  view.on_people = latent.bodies.empty() ? cv::Mat(view.depth.size(), CV_8UC1, cv::Scalar(0))
                                         : cv::Mat(latent.bodies >= FirstPersonBody(model.get()));
  view.X_WC = at.pose;
  view.grey = film->Develop(latent).image.pixels;
  return view;
}

CrowdStage::CrowdStage(const CrowdOptions& options, uint64_t seed) : parts_(std::make_unique<Parts>(options, seed)) {}

CrowdStage::~CrowdStage() = default;

CrowdPair CrowdStage::Film(int number) {
  Parts& stage = *parts_;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    const std::string name = std::to_string(number) + "." + std::to_string(attempt);
    RandomStream random(stage.seed, "crowd.pair." + name);
    const StampedPose first{Parts::Stamp(kBegin_s), stage.DrawPlace(random)};
    const StampedPose second{Parts::Stamp(kBegin_s + stage.options.interval_s), first.pose * stage.DrawStep(random)};
    if (!IsFree(stage.scene, second.pose.translation)) continue;
    *stage.people = stage.DrawPeople({first, second}, random);
    CrowdPair pair{stage.camera, {}, {}, stage.PutThings(first.pose, random)};
    stage.Place(pair.things, false);
    pair.a = stage.View(first, random, "a." + name);
    if (cv::countNonZero(pair.a.depth > kNear_m) * 2 < pair.a.depth.rows * pair.a.depth.cols) continue;
    stage.Place(pair.things, true);
    pair.b = stage.View(second, random, "b." + name);
    return pair;
  }
  throw BadInput("scene " + stage.scene.name + ": no two free places that see far; expected a scene with free floor");
}

std::vector<CrowdView> CrowdStage::FilmWalk(int number, int views) {
  Parts& stage = *parts_;
  const std::string name = "walk" + std::to_string(number);
  RandomStream random(stage.seed, "crowd." + name);
  std::vector<StampedPose> path{{Parts::Stamp(kBegin_s), stage.DrawPlace(random)}};
  for (int i = 1; i < views; ++i) {
    Pose from = path.back().pose, next = from * stage.DrawStep(random);
    // Level, or tilts would add up; and aside where there is no room.
    const auto level = [](const Pose& X_WC) {
      const Eigen::Vector3d ahead = X_WC.R().col(2);
      return CameraAt(X_WC.translation, std::atan2(ahead.y(), ahead.x()));
    };
    const auto goes = [&](const Pose& pose) {
      return IsFree(stage.scene, {pose.translation.x(), pose.translation.y(), from.translation.z()});
    };
    for (int attempt = 0; attempt < kMaxAttempts && !goes(next); ++attempt) {
      from = level(from) * Pose(RotY(kTurnAside), {0, 0, 0});
      next = from * stage.DrawStep(random);
    }
    if (!goes(next)) next = from;
    next = level(next);
    next.translation.z() = path.front().pose.translation.z();
    path.push_back({Parts::Stamp(kBegin_s + i * stage.options.interval_s), next});
  }
  *stage.people = stage.DrawPeople(path, random);
  stage.Place(stage.PutThings(path.front().pose, random), false);
  std::vector<CrowdView> film;
  for (size_t i = 0; i < path.size(); ++i) film.push_back(stage.View(path[i], random, name + "." + std::to_string(i)));
  return film;
}

}  // namespace gaitcam
