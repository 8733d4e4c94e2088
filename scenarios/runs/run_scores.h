/// Everything that there is to score of a run: poses, a mapped floor, a topological map.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/trajectory.h"
#include "models/place.h"
#include "results/floor_score.h"
#include "results/place_graph_score.h"
#include "results/score.h"

namespace gaitcam {

struct RunScores {
  std::optional<Scores> scores;
  std::string not_scored;  ///< Why there are none.
  std::optional<FloorComparison> map;
  std::optional<PlaceGraphComparison> places;
};

/// A system that maps places and gives no poses is scored by its places alone.
RunScores ScoreRun(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                   const Place& place, const ScoreOptions& options);

/// What was mapped, into a run's folder: map/*.png, places.graphml (with the true positions of the places) and
/// panoramas/*.png. @throws MissingResource if it cannot be written.
void WriteMaps(const Estimate& estimate, const RunScores& scores, const std::filesystem::path& folder);

}  // namespace gaitcam
