#include "scenarios/code/runs/run_scores.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "algorithms/io/trajectory_file.h"

namespace gaitcam {

namespace {

/// Of the walks that taught the map; empty if the file has gone elsewhere without it.
Trajectory TaughtTruth(const ResolvedScenario& resolved) {
  if (!resolved.map) return {};
  std::filesystem::path file = resolved.map_file.parent_path() / kTaughtName;
  if (!std::filesystem::exists(file)) file = resolved.map_file.parent_path() / "truth.txt";
  if (!std::filesystem::exists(file)) return {};
  return ReadTrajectory(file, TrajectoryFormat::kTum).trajectory;
}

std::filesystem::path TruthBeside(const std::filesystem::path& sensors) {
  return sensors.string() + "-truth/groundtruth.txt";
}

Scores ScorePoses(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                  const ScoreOptions& options) {
  if (FindMap<PlaceGraph>(estimate.maps) && estimate.ToTrajectory().empty()) return ScoreWithoutPoses(estimate);
  try {
    return ScoreEstimate(estimate, truth, frame_stamps, options);
  } catch (const TooLittleData& e) {
    if (!FindMap<TaughtDrive>(estimate.maps)) throw;
    Scores scores = ScoreWithoutPoses(estimate);
    scores.remarks.push_back(std::string("poses are not scored: ") + e.what());
    return scores;
  }
}

std::optional<CarriedSpan> CarriedIn(const Scenario& scenario) {
  if (!scenario.kidnap) return std::nullopt;
  const auto stamp_ns = [](double time_s) { return kClockStart_ns + std::llround(1e9 * time_s); };
  return CarriedSpan{stamp_ns(scenario.kidnap->at_s), stamp_ns(scenario.kidnap->at_s + scenario.kidnap->over_s)};
}

}  // namespace

RunScores ScoreRun(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                   const ResolvedScenario& resolved, const PeopleAt& people) {
  RunScores run;
  const ScoreOptions& options = resolved.scenario.score;
  try {
    Scores scores = ScorePoses(estimate, truth, frame_stamps, options);
    const Trajectory taught = TaughtTruth(resolved);
    run.maps =
        ResultsOf(estimate.maps, {resolved.scene, truth, taught, scores, people, CarriedIn(resolved.scenario),
                                  options.places.value_or(PlaceGraphScoreOptions()), resolved.scenario.video.enabled});
    for (const MapResult& map : run.maps) {
      scores.scores.insert(scores.scores.end(), map.scores.begin(), map.scores.end());
    }
    run.scores = std::move(scores);
  } catch (const TooLittleData& e) {
    run.not_scored = e.what();
  }
  return run;
}

bool HasTruthBeside(const std::filesystem::path& sensors) { return std::filesystem::exists(TruthBeside(sensors)); }

Scores ScoreAgainstTruthBeside(const Estimate& estimate, const std::filesystem::path& sensors,
                               const std::string& system) {
  std::vector<int64_t> stamps;
  for (const FrameEstimate& frame : estimate.frames) stamps.push_back(frame.stamp_ns);
  try {
    return ScoreEstimate(estimate, ReadTrajectory(TruthBeside(sensors)).trajectory, stamps, {});
  } catch (const TooLittleData&) {
    if (estimate.failure.empty()) throw;
    throw TooLittleData(system + " failed: " + estimate.failure);
  }
}

void WriteMaps(const RunScores& scores, const std::filesystem::path& folder) {
  for (const MapResult& map : scores.maps) map.write(folder);
}

}  // namespace gaitcam
