#include "results/scoring/score_catalogue.h"

#include "results/scoring/drive_score.h"
#include "results/scoring/floor_pose.h"
#include "results/scoring/floor_score.h"
#include "results/scoring/place_graph_score.h"
#include "results/scoring/pose_graph_score.h"
#include "results/scoring/pose_metrics.h"
#include "results/scoring/route_map_score.h"

namespace gaitcam {

std::vector<Score> ScoreCatalogue(const ScoreOptions& options) {
  std::vector<Score> catalogue = NamesOf(PoseMetrics(options, true));
  for (const Score& score : NamesOf(LivePoseMetrics(options))) catalogue.push_back(score);
  return catalogue;
}

std::vector<Score> MapScoreCatalogue() {
  std::vector<Score> catalogue = NamesOf(FloorMetrics({}));
  for (const Score& score : NamesOf(FloorPoseMetrics())) catalogue.push_back(score);
  for (const Score& score : NamesOf(PlaceGraphMetrics())) catalogue.push_back(score);
  for (const Score& score : NamesOf(PoseGraphMetrics())) catalogue.push_back(score);
  for (const Score& score : NamesOf(RouteMapMetrics())) catalogue.push_back(score);
  for (const Score& score : NamesOf(DriveMetrics())) catalogue.push_back(score);
  return catalogue;
}

}  // namespace gaitcam
