#include "scenarios/runs/run_scores.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/place_graph_file.h"
#include "scenarios/runs/mapped_floor.h"

namespace gaitcam {
namespace {

void WritePanoramas(const PlaceGraph& graph, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (size_t n = 0; n < graph.nodes.size(); ++n) {
    if (graph.nodes[n].panorama.empty()) continue;
    const std::filesystem::path file = folder / fmt::format("place_{:03}.png", n);
    if (!cv::imwrite(file.string(), graph.nodes[n].panorama))
      throw MissingResource(file.string() + ": cannot be written");
  }
}

}  // namespace

RunScores ScoreRun(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                   const Place& place, const ScoreOptions& options) {
  RunScores run;
  const bool places_alone = estimate.places && estimate.ToTrajectory().empty();
  try {
    run.scores = places_alone ? ScoreWithoutPoses(estimate) : ScoreEstimate(estimate, truth, frame_stamps, options);
    if (!places_alone) run.map = AddMapScores(estimate, place, *run.scores);
    if (estimate.places) run.places = ComparePlaceGraph(*estimate.places, truth);
  } catch (const TooLittleData& e) {
    run.scores.reset();
    run.not_scored = e.what();
  }
  if (run.places) {
    run.scores->scores.insert(run.scores->scores.end(), run.places->scores.begin(), run.places->scores.end());
  }
  return run;
}

void WriteMaps(const Estimate& estimate, const RunScores& scores, const std::filesystem::path& folder) {
  if (scores.map) WriteMapPictures(*scores.map, folder / "map");
  if (!scores.places) return;
  WritePlaceGraph(folder / "places.graphml", *estimate.places, scores.places->nodes_m);
  WritePanoramas(*estimate.places, folder / "panoramas");
}

}  // namespace gaitcam
