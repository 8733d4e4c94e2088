#include "scenarios/code/files/localisation_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "algorithms/places/place_recognition.h"

namespace gaitcam {
namespace {

using Problem = std::optional<LocalisationProblem>;

Problem AboutWords(const std::string& key, const std::vector<std::string>& words,
                   const std::vector<std::string>& known) {
  for (const std::string& word : words) {
    if (std::count(known.begin(), known.end(), word) > 0) continue;
    return LocalisationProblem{key, OneOf(known).Refusal(word)};
  }
  return std::nullopt;
}

Problem AboutNumbers(const std::string& key, const std::vector<double>& numbers, const Interval& permitted) {
  for (const double number : numbers) {
    if (!permitted.Contains(number))
      return LocalisationProblem{key, fmt::format("{:g} is not permitted; expected {}", number, permitted.ToText())};
  }
  return std::nullopt;
}

Problem AboutField(const LocalisationOptions& options, const Scene& scene) {
  const Eigen::Vector2d low = options.centre_m - 0.5 * options.field_m, high = options.centre_m + 0.5 * options.field_m;
  if (!(options.field_m.minCoeff() > 2 * options.margin_m)) {
    return LocalisationProblem{"field_m", fmt::format("{:g} x {:g} m leave nothing within the margin of {:g} m",
                                                      options.field_m.x(), options.field_m.y(), options.margin_m)};
  }
  if ((low - scene.floor_min).minCoeff() >= 0 && (scene.floor_max - high).minCoeff() >= 0) return std::nullopt;
  return LocalisationProblem{
      "field_m",
      fmt::format("the field from ({:g}, {:g}) to ({:g}, {:g}) m reaches beyond the floor of {}, from ({:g}, "
                  "{:g}) to ({:g}, {:g}) m",
                  low.x(), low.y(), high.x(), high.y(), scene.name, scene.floor_min.x(), scene.floor_min.y(),
                  scene.floor_max.x(), scene.floor_max.y())};
}

}  // namespace

std::optional<LocalisationProblem> FindProblem(const LocalisationOptions& options, const Scene& scene) {
  Problem problem = AboutWords("methods", options.methods, PlaceIndexNames());
  if (!problem) problem = AboutNumbers("occlusions", options.occlusions, Between(0.01, 0.9));
  if (!problem) problem = AboutNumbers("walk_exposures_ms", options.walk_exposures_ms, Between(0, 200));
  if (!problem) problem = AboutField(options, scene);
  return problem;
}

}  // namespace gaitcam
