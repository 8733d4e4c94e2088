/// Everything that there is to score of a run: poses and maps.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/score.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/map_results.h"

namespace gaitcam {

struct RunScores {
  std::optional<Scores> scores;
  std::string not_scored;       ///< Why there are none.
  std::vector<MapResult> maps;  ///< Of Estimate::maps, which must outlive them.
};

/// Scores of maps follow those of the poses. A system that gives a graph of places and no poses is scored by its graph
/// alone; so is one that drives by a map and hardly ever finds itself in it. Where the walk that taught that map truly
/// went is read from taught.txt or truth.txt beside the map. `people` are where they truly were. The result refers to
/// `estimate` and `truth`, which must outlive it.
RunScores ScoreRun(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                   const ResolvedScenario& resolved, const PeopleAt& people);

/// Whether a recorded folder has its truth beside it, as `record` leaves it.
bool HasTruthBeside(const std::filesystem::path& sensors);

/// Scores what a system said of a recorded folder against that truth.
/// @param system its name, for messages
/// @throws TooLittleData, which says so if the system failed.
Scores ScoreAgainstTruthBeside(const Estimate& estimate, const std::filesystem::path& sensors,
                               const std::string& system);

/// Each map's files into a run's folder. @throws MissingResource if one cannot be written.
void WriteMaps(const RunScores& scores, const std::filesystem::path& folder);

}  // namespace gaitcam
