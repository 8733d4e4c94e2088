/// One run: simulate, film, track, score, report.

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "results/reports/report.h"
#include "results/scoring/score.h"
#include "scenarios/code/files/scenario.h"
#include "sim/simulation.h"

namespace gaitcam {

struct RunOptions {
  std::filesystem::path out;  ///< Folder of the results; replaced if it is an older run.
  bool quiet = false;
  std::function<bool()> interrupted = [] { return false; };
  std::filesystem::path cache = {};  ///< Where a localisation keeps its pictures; empty: nowhere.
};

struct RunOutcome {
  std::filesystem::path folder;
  std::string status;  ///< "finished", "fell" or "interrupted".
  double end_time_s = 0;
  std::optional<Scores> scores;  ///< None when too little was covered to score.
  std::string no_scores_reason;
  std::string failure = {};         ///< Why the system stopped working; empty if it did not.
  std::vector<Score> of_film = {};  ///< What the camera saw: blur_median_px, blur_p95_px over the frames' medians.
  std::string table = {};           ///< For a terminal, where that is not the list of all scores.
};

/// Runs a scenario into a folder: estimate.txt, truth.txt (TUM format), frames.csv, scores.json, scenario.yaml
/// (resolved), walk.mp4 and report.html; of a system that maps the floor, also the pictures map/*.png. What was filmed
/// until a fall or an interrupt is kept and scored. Where too little was covered to score, the folder is written all
/// the same, its scores.json saying why.
/// @throws BadInput, MissingResource.
RunOutcome RunScenario(const ResolvedScenario& resolved, const RunOptions& options);

/// What the simulator needs to know of a scenario: as its seed varies it.
SimulationOptions SimulationOptionsOf(const ResolvedScenario& resolved);

/// What corrects the robot's course; a wheeled base's drive holds it on its path by its true pose.
PathFeedback SteeredBy(const ResolvedScenario& resolved);
/// "steered by its true pose", "steered by its own odometry", "not steered".
std::string SteeringText(const ResolvedScenario& resolved);

/// How a simulation ended, or that it was left while walking.
RunEnd EndOf(const Simulation& simulation);
/// "finished", "fell", "interrupted".
std::string StatusText(RunEnd end);

/// Asks the robot whether it can do what the scenario says, without running it. @throws BadInput naming the limit.
void CheckPlan(const ResolvedScenario& resolved);

}  // namespace gaitcam
