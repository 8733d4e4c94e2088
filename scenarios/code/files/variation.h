/// `variation:` of a scenario: in what one repeat of an experiment differs from the next, by seed. It changes the walk
/// and its frames.

#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/option_value.h"
#include "models/code/scenes/scene.h"
#include "sim/walking/path.h"
#include "sim/world/world.h"

namespace gaitcam {

enum class VariationPreset { kNone, kRepeat };
constexpr auto WordsOf(VariationPreset) {
  return std::array{EnumWord{VariationPreset::kNone, "none"}, EnumWord{VariationPreset::kRepeat, "repeat"}};
}

/// Limits of uniform distributions, from which the seed draws once per walk. The defaults change nothing.
struct VariationOptions {
  using DescribedTag = void;
  using Preset = VariationPreset;
  Preset preset = Preset::kNone;
  double start_m = 0;
  double start_deg = 0;
  double clearance_m = 0.25;
  double mass_ratio = 0;
  double friction_ratio = 0;
  double light_ratio = 0;
  bool scene_seed = false;
  double furniture_m = 0;
  double furniture_deg = 0;

  static VariationOptions Of(Preset preset);
};

template <class Visitor>
void VisitFields(Visitor& visit, VariationOptions& o) {
  visit("preset", o.preset, EnumWords<VariationPreset>(),
        "what the other keys start from: none; or repeat: start 0.15 m and 10 deg, mass, friction 0.1, light 0.2, the "
        "scene's seed, furniture 0.03 m and 3 deg");
  visit("start_m", o.start_m, Between(0, 5),
        "the start, and the path with it, lies up to so far beside, along x and y");
  visit("start_deg", o.start_deg, Between(0, 180), "... and is turned by up to so much");
  visit("clearance_m", o.clearance_m, Between(0, 5),
        "a start is drawn again whose path comes nearer to what stands about, or the floor's edge, than this, or than "
        "half of what the scenario's own path keeps, if that is less");
  visit("mass_ratio", o.mass_ratio, Between(0, 0.5),
        "each link's mass and inertia times 1 + uniform(-r, r); the larger one of this and physics.mass_noise_ratio");
  visit("friction_ratio", o.friction_ratio, Between(0, 0.9), "floor friction likewise");
  visit("light_ratio", o.light_ratio, Between(0, 0.9), "all light times 1 + uniform(-r, r)");
  visit("scene_seed", o.scene_seed, Nested(), "the scene has a seed of its own: scattered posters, prints, textures");
  visit("furniture_m", o.furniture_m, Between(0, 1), "each piece of furniture stands up to so far beside, in x and y");
  visit("furniture_deg", o.furniture_deg, Between(0, 180), "... and is turned by up to so much");
}

void ReadOption(const OptionValue& node, VariationOptions& value);
/// Whether nothing varies; a resolved scenario then has no such block.
bool SaysNothing(const VariationOptions& value);

/// The scene as this seed finds it. @throws BadInput if no scene of 20 that it draws has room for its scattered things.
Scene ReadSceneOfSeed(const std::string& name_or_path, const VariationOptions& options, uint64_t seed);

/// x m, y m, yaw deg of this seed. @param nominal where the scenario has it. @param part of the path's length that is
/// walked before the time is up, 0 to 1. @throws BadInput in one line if no start of 2000 that it draws keeps its path
/// clear.
Eigen::Vector3d StartOfSeed(const Eigen::Vector3d& nominal, const PathOptions& path, double part, const Scene& scene,
                            const VariationOptions& options, uint64_t seed);

/// What is off about masses and friction, with what the variation adds.
PhysicsOptions Varied(const PhysicsOptions& physics, const VariationOptions& options);

/// How far a path stays from all that a robot would run into, and within the floor; below 0 inside of something.
/// @param part of its length, from its beginning. @param start x m, y m, yaw deg. @param enough to know: the search
/// ends where it falls below.
double Clearance(const PathOptions& path, double part, const Eigen::Vector3d& start, const Scene& scene, double enough);

}  // namespace gaitcam
