#include "scenarios/code/files/variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "models/code/scenes/footprint.h"
#include "models/code/yaml/preset_block.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace {

constexpr int kSceneDraws = 20, kStartDraws = 2000;
constexpr double kAlongPath_m = 0.05;  // from one point of the path to the next that is asked
constexpr double kHigh_m = 1.5;        // what hangs higher is in no robot's way
constexpr double kHalf = 0.5;          // of the nominal clearance must remain

/// Reads the first scene that can be built; the last one's refusal is passed on.
Scene FirstThatCanBe(const std::string& name, SceneVariation variation, bool new_seed, RandomStream random) {
  for (int attempt = 1;; ++attempt) {
    if (new_seed) variation.seed = random.Bits() >> 32;
    try {
      return ReadVariedScene(name, ModelsFolder(), variation);
    } catch (const BadInput&) {
      if (!new_seed || attempt == kSceneDraws) throw;
    }
  }
}

}  // namespace

VariationOptions VariationOptions::Of(Preset preset) {
  VariationOptions o;
  o.preset = preset;
  if (preset == Preset::kNone) return o;
  o.start_m = 0.15;
  o.start_deg = 10;
  o.mass_ratio = o.friction_ratio = 0.1;
  o.light_ratio = 0.2;
  o.scene_seed = true;
  o.furniture_m = 0.03;
  o.furniture_deg = 3;
  return o;
}

void ReadOption(const OptionValue& node, VariationOptions& value) { ReadPresetBlock(node, value); }

bool SaysNothing(const VariationOptions& value) { return IsPlainBlock(value); }

Scene ReadSceneOfSeed(const std::string& name_or_path, const VariationOptions& options, uint64_t seed) {
  SceneVariation variation;
  variation.light = 1 + RandomStream(seed, "variation.light").Uniform(-options.light_ratio, options.light_ratio);
  variation.furniture_m = options.furniture_m;
  variation.furniture_deg = options.furniture_deg;
  variation.draw = seed;
  return FirstThatCanBe(name_or_path, variation, options.scene_seed, RandomStream(seed, "variation.scene"));
}

double Clearance(const PathOptions& options, double part, const Eigen::Vector3d& start, const Scene& scene,
                 double enough) {
  const Path path(options, Pose(RotZ(start.z() * kRadPerDeg), {start.x(), start.y(), 0}));
  std::vector<std::vector<cv::Point2f>> footprints;
  for (const SceneBox& box : scene.boxes) {
    std::vector<cv::Point2f> footprint = Footprint(box, kHigh_m);
    if (!footprint.empty()) footprints.push_back(std::move(footprint));
  }
  double clearance = std::numeric_limits<double>::infinity();
  const double length = part * path.Length();
  const int steps = int(length / kAlongPath_m) + 1;
  for (int i = 0; i <= steps && clearance >= enough; ++i) {
    const Eigen::Vector2d p = path.PoseAt(length * i / steps).position;
    clearance = std::min({clearance, (p - scene.floor_min).minCoeff(), (scene.floor_max - p).minCoeff()});
    for (const std::vector<cv::Point2f>& footprint : footprints) {
      const cv::Point2f at(float(p.x()), float(p.y()));
      clearance = std::min(clearance, -cv::pointPolygonTest(footprint, at, true));
    }
  }
  return clearance;
}

Eigen::Vector3d StartOfSeed(const Eigen::Vector3d& nominal, const PathOptions& path, double part, const Scene& scene,
                            const VariationOptions& options, uint64_t seed) {
  if (options.start_m == 0 && options.start_deg == 0) return nominal;
  const double kept = Clearance(path, part, nominal, scene, -std::numeric_limits<double>::infinity());
  if (kept <= 0) throw BadInput("variation: the scenario's own path leads through something, or off the floor");
  const double wanted = std::min(options.clearance_m, kHalf * kept);
  RandomStream random(seed, "variation.start");
  for (int i = 0; i < kStartDraws; ++i) {
    Eigen::Vector3d start = nominal;
    start.x() += random.Uniform(-options.start_m, options.start_m);
    start.y() += random.Uniform(-options.start_m, options.start_m);
    start.z() += random.Uniform(-options.start_deg, options.start_deg);
    if (Clearance(path, part, start, scene, wanted) >= wanted) return start;
  }
  throw BadInput(
      fmt::format("variation: none of {} starts that seed {} draws keeps the path {:.2g} m from what stands "
                  "about; expected a smaller variation.start_m or start_deg",
                  kStartDraws, seed, wanted));
}

PhysicsOptions Varied(const PhysicsOptions& physics, const VariationOptions& options) {
  PhysicsOptions varied = physics;
  varied.mass_noise_ratio = std::max(physics.mass_noise_ratio, options.mass_ratio);
  varied.friction_noise_ratio = std::max(physics.friction_noise_ratio, options.friction_ratio);
  return varied;
}

}  // namespace gaitcam
