#include "scenarios/code/runs/run_scores.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

RunScores ScoreRun(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                   const Scene& scene, const ScoreOptions& options) {
  RunScores run;
  const bool graph_alone = FindMap<PlaceGraph>(estimate.maps) && estimate.ToTrajectory().empty();
  try {
    Scores scores = graph_alone ? ScoreWithoutPoses(estimate) : ScoreEstimate(estimate, truth, frame_stamps, options);
    run.maps = ResultsOf(estimate.maps, {scene, truth, scores, options.places.value_or(PlaceGraphScoreOptions())});
    for (const MapResult& map : run.maps) {
      scores.scores.insert(scores.scores.end(), map.scores.begin(), map.scores.end());
    }
    run.scores = std::move(scores);
  } catch (const TooLittleData& e) {
    run.not_scored = e.what();
  }
  return run;
}

void WriteMaps(const RunScores& scores, const std::filesystem::path& folder) {
  for (const MapResult& map : scores.maps) map.write(folder);
}

}  // namespace gaitcam
