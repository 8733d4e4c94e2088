#include "scenarios/code/runs/place_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/up_direction.h"
#include "scenarios/code/runs/pasted_robots.h"
#include "scenarios/code/runs/runner.h"
#include "sim/standing_robot.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr TruthOptions kNoPictures{false, false, false};
constexpr TruthOptions kBlurAlone{false, false, true};

// ---- Conditions

std::string OcclusionName(double ratio) { return fmt::format("occlusion_{:g}", 100 * ratio); }
std::string LightName(LightChange change) { return fmt::format("light_{}", ToWord(change)); }
std::string WalkName(double exposure_ms) { return fmt::format("walk_{:g}ms", exposure_ms); }

/// A room in another light.
Scene Relit(const Scene& scene, LightChange change) {
  Scene other = scene;
  for (SceneLight& light : other.lights) {
    if (change == LightChange::kMoved) {
      light.position = RotZ(kPi / 2) * light.position;
      light.direction = RotZ(kPi / 2) * light.direction;
    } else if (change == LightChange::kDimmed) {
      light.brightness *= 0.5;
    } else {
      light.rgb = {1, 0.75, 0.5};
    }
  }
  if (change == LightChange::kDimmed) other.ambient *= 0.5;
  if (change == LightChange::kColoured) other.ambient_rgb = {1, 0.75, 0.5};
  return other;
}

// ---- Poses

/// Where views may be taken.
bool IsWithin(const LocalisationOptions& options, const Vector2d& p) {
  const Vector2d half = 0.5 * options.field_m - Vector2d::Constant(options.margin_m);
  return ((p - options.centre_m).cwiseAbs() - half).maxCoeff() <= 0;
}

/// x m, y m, yaw deg.
Vector3d RandomPose(const LocalisationOptions& options, RandomStream& random) {
  const Vector2d half = 0.5 * options.field_m - Vector2d::Constant(options.margin_m);
  const double x = random.Uniform(-half.x(), half.x()), y = random.Uniform(-half.y(), half.y());
  return {options.centre_m.x() + x, options.centre_m.y() + y, random.Uniform(-180, 180)};
}

/// From where a straight walk stays in the field.
Vector3d RandomWalk(const LocalisationOptions& options, RandomStream& random) {
  for (int attempt = 0; attempt < 10000; ++attempt) {
    const Vector3d pose = RandomPose(options, random);
    const double yaw = pose.z() * kPi / 180;
    if (IsWithin(options, pose.head<2>() + options.walk_m * Vector2d(std::cos(yaw), std::sin(yaw)))) return pose;
  }
  throw BadInput(fmt::format("localisation.walk_m = {:g}: no such walk stays in the field", options.walk_m));
}

double HeadingOf(const Pose& X_WC) {
  const Vector3d forward = X_WC.R().col(2);
  return std::atan2(forward.y(), forward.x());
}

SimulationOptions StandingOptions(const ResolvedScenario& resolved) {
  SimulationOptions options = SimulationOptionsOf(resolved);
  options.start.reset();
  return options;
}

SimulationOptions WalkingOptions(const ResolvedScenario& resolved, double exposure_ms) {
  const Scenario& scenario = resolved.scenario;
  SimulationOptions options = SimulationOptionsOf(resolved);
  options.start.reset();
  options.path.kind = PathKind::kStraight;
  options.path.length_m = scenario.localisation->walk_m;
  options.path.feedback = PathFeedback::kTruth;
  options.duration_s = 0;
  options.camera.rate_hz = 1 / scenario.localisation->walk_every_s;
  options.camera.exposure.exposure_ms = exposure_ms;
  if (options.camera.auto_exposure) options.camera.auto_exposure->enabled = false;
  return options;
}

uint64_t SeedOf(uint64_t seed, const char* what, int number) {
  return RandomStream(seed, fmt::format("localisation.{}.{}", what, number)).Bits();
}

// ---- The work

class PlaceViewMaker {
 public:
  PlaceViewMaker(const ResolvedScenario& resolved, const std::function<bool(int, int)>& advance)
      : resolved_(resolved),
        scenario_(resolved.scenario),
        options_(*scenario_.localisation),
        advance_(advance),
        all_(options_.columns * options_.rows + int(PlaceConditions(options_).size()) * options_.queries) {}

  PlaceViews Make() {
    views_.grid = GridOf(options_);
    const auto steps = {&PlaceViewMaker::Stand, &PlaceViewMaker::Occlude, &PlaceViewMaker::ChangeLight,
                        &PlaceViewMaker::Walk};
    for (const auto step : steps) {
      if (!stopped_) (this->*step)();
    }
    return std::move(views_);
  }

 private:
  void Advance() {
    if (!advance_(++done_, all_)) stopped_ = true;
  }

  /// Projection and layout follow from how the camera stands.
  void Prepare(const Calibration& calibration) {
    camera_ = calibration.camera;
    up_C_ = calibration.standing.value().up_C;
    eye_height_m_ = calibration.standing->height_m;
    views_.layout = LayoutFor(camera_, up_C_, options_.panorama_width_px, options_.panorama_height_px);
    projection_.emplace(camera_, up_C_, views_.layout);
    views_.view_width_px = projection_->width_px();
  }

  /// References and plain views.
  void Stand() {
    StandingRobot robot(resolved_.robot, resolved_.scene, StandingOptions(resolved_), scenario_.seed);
    views_.renderer = robot.gl().info();
    Prepare(robot.calibration());
    for (size_t i = 0; i < views_.grid.size() && !stopped_; ++i) {
      views_.references.push_back(Scan(robot, views_.grid.At(i), SeedOf(scenario_.seed, "reference", int(i))));
      Advance();
    }
    RandomStream random(scenario_.seed, "localisation.queries");
    for (int i = 0; i < options_.queries; ++i) poses_.push_back(RandomPose(options_, random));
    Look(robot, "plain");
  }

  PlaceReference Scan(StandingRobot& robot, const Vector2d& at, uint64_t seed) {
    const std::vector<SimulatedFrame> frames = robot.Scan({at.x(), at.y(), 0}, seed, kNoPictures);
    PanoramaBuilder builder(*projection_, views_.layout, options_.panorama);
    for (const SimulatedFrame& frame : frames) {
      const ScanState& scan = *frame.observation.scan;
      builder.Add(frame.observation.image.pixels, scan.pan_rad + scan.body_turn_rad);
    }
    const Panorama panorama = builder.Finish();
    PlaceReference reference;
    reference.position_m = frames.front().truth.X_WB->translation.head<2>();
    reference.heading_rad = frames.front().truth.X_WB->Yaw();
    reference.panorama = panorama.image;
    reference.frames = panorama.frames;
    reference.seam_error_px = panorama.mean_seam_error_px;
    return reference;
  }

  PlaceQuery QueryOf(const std::string& condition, const SimulatedFrame& frame) const {
    PlaceQuery query;
    query.condition = condition;
    query.position_m = frame.truth.X_WB->translation.head<2>();
    query.heading_rad = HeadingOf(frame.truth.X_WC);
    query.image = frame.observation.image.pixels.clone();
    query.blur_px = frame.truth.blur_median_px;
    return query;
  }

  /// From all poses, one view each.
  void Look(StandingRobot& robot, const std::string& condition) {
    for (size_t i = 0; i < poses_.size() && !stopped_; ++i) {
      PlaceQuery query = QueryOf(condition, robot.View(poses_[i], SeedOf(scenario_.seed, "view", int(i)), kNoPictures));
      query.view = projection_->ProjectView(query.image);
      views_.queries.push_back(std::move(query));
      Advance();
    }
  }

  /// The plain views once more, with robots in the way.
  void Occlude() {
    if (options_.occlusions.empty()) return;
    const std::vector<RobotPicture> pictures = PictureRobot(resolved_.robot, resolved_.scene, scenario_.gait.options,
                                                            scenario_.camera.renderer, eye_height_m_);
    for (const double ratio : options_.occlusions) {
      RandomStream random(scenario_.seed, "localisation." + OcclusionName(ratio));
      for (size_t i = 0; i < poses_.size() && !stopped_; ++i) {
        PlaceQuery query = views_.queries[i];
        query.condition = OcclusionName(ratio);
        cv::Mat image = query.image;
        if (image.type() == CV_8UC1) cv::cvtColor(query.image, image, cv::COLOR_GRAY2BGR);
        const PastedImage pasted = PasteRobots(image, pictures, camera_, up_C_, *projection_, ratio, random);
        query.image = pasted.image;
        query.covered_ratio = pasted.covered_ratio;
        query.view = projection_->ProjectView(query.image);
        views_.queries.push_back(std::move(query));
        Advance();
      }
    }
  }

  void ChangeLight() {
    for (const LightChange change : options_.lights) {
      if (stopped_) return;
      StandingRobot robot(resolved_.robot, Relit(resolved_.scene, change), StandingOptions(resolved_), scenario_.seed);
      Look(robot, LightName(change));
    }
  }

  void Walk() {
    for (const double exposure_ms : options_.walk_exposures_ms) {
      if (stopped_) return;
      Simulation walk(resolved_.robot, resolved_.scene, WalkingOptions(resolved_, exposure_ms), scenario_.seed);
      RandomStream random(scenario_.seed, "localisation.walks");
      const int max_walks = 10 * options_.queries;
      int missing = options_.queries;
      for (int leg = 0; leg < max_walks && missing > 0 && !stopped_; ++leg) {
        walk.Restart(RandomWalk(options_, random), SeedOf(scenario_.seed, "walk", leg));
        missing -= FilmWalk(walk, WalkName(exposure_ms), missing);
      }
      if (missing > 0 && !stopped_) {
        throw BadInput(fmt::format("localisation: {} walks gave only {} views with both feet on their way", max_walks,
                                   options_.queries - missing));
      }
    }
  }

  /// One walk's frames while it steps, levelled by what the robot's own inertial sensors say.
  /// @returns how many.
  int FilmWalk(Simulation& walk, const std::string& condition, int most) {
    UpDirection up(walk.calibration().imu, up_C_);
    int taken = 0;
    while (taken < most && !stopped_) {
      const std::optional<SimulatedFrame> frame = walk.Next(kBlurAlone);
      if (!frame) break;
      up.Add(frame->observation.imu);
      if (frame->truth.gait->step < 0) continue;  // stands still
      PlaceQuery query = QueryOf(condition, *frame);
      query.view = projection_->ProjectView(query.image, up.up_C());
      views_.queries.push_back(std::move(query));
      ++taken;
      Advance();
    }
    return taken;
  }

  const ResolvedScenario& resolved_;
  const Scenario& scenario_;
  const LocalisationOptions& options_;
  const std::function<bool(int, int)>& advance_;
  const int all_;
  int done_ = 0;
  bool stopped_ = false;
  PlaceViews views_;
  std::vector<Vector3d> poses_;
  CameraModel camera_;
  Vector3d up_C_ = -Vector3d::UnitY();
  double eye_height_m_ = 0;
  std::optional<CylinderProjection> projection_;
};

}  // namespace

std::vector<std::string> PlaceConditions(const LocalisationOptions& options) {
  std::vector<std::string> conditions{"plain"};
  for (const double ratio : options.occlusions) conditions.push_back(OcclusionName(ratio));
  for (const LightChange change : options.lights) conditions.push_back(LightName(change));
  for (const double exposure_ms : options.walk_exposures_ms) conditions.push_back(WalkName(exposure_ms));
  return conditions;
}

std::string PlaceConditionText(const std::string& condition) {
  if (condition == "plain") return "standing, as the references";
  if (condition == "light_moved") return "all lights turned by 90\u00b0 about the vertical";
  if (condition == "light_dimmed") return "all light halved, as display values: about a fifth of the light";
  if (condition == "light_coloured") return "all light turned orange";
  if (condition.starts_with("occlusion_")) return condition.substr(10) + " % of the view behind pasted robots";
  return "filmed while walking, exposure " + condition.substr(5, condition.size() - 7) + " ms";
}

PlaceGrid GridOf(const LocalisationOptions& options) {
  PlaceGrid grid{options.columns, options.rows};
  grid.step_m = options.field_m.cwiseQuotient(Vector2d(options.columns, options.rows));
  grid.first_m = options.centre_m - 0.5 * options.field_m + 0.5 * grid.step_m;
  return grid;
}

void CheckPlaceViews(const ResolvedScenario& resolved) {
  const Scenario& scenario = resolved.scenario;
  CheckSimulation(resolved.robot, resolved.scene, StandingOptions(resolved), scenario.seed);
  CheckHeadScan(resolved.robot, StandingOptions(resolved));
  RandomStream random(scenario.seed, "localisation.walks");
  if (!scenario.localisation->walk_exposures_ms.empty()) RandomWalk(*scenario.localisation, random);
  for (const double exposure_ms : scenario.localisation->walk_exposures_ms)
    CheckSimulation(resolved.robot, resolved.scene, WalkingOptions(resolved, exposure_ms), scenario.seed);
}

PlaceViews MakePlaceViews(const ResolvedScenario& resolved, const std::function<bool(int done, int all)>& advance) {
  return PlaceViewMaker(resolved, advance).Make();
}

}  // namespace gaitcam
