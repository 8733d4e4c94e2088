#include "results/score_catalogue.h"

#include <limits>

#include "results/floor_score.h"
#include "results/place_graph_score.h"

namespace gaitcam {

/// A perfect estimate of a made-up walk is scored, so that names can never differ from those of real runs.
std::vector<Score> ScoreCatalogue(const ScoreOptions& options) {
  ScoreOptions always = options;
  always.min_pairs = 3;
  always.min_coverage_ratio = 0;
  always.association = {};
  Trajectory truth;
  std::vector<int64_t> stamps;
  for (int i = 0; i < 20; ++i) {
    StampedPose p;
    p.stamp_ns = int64_t(i) * 100'000'000;
    p.pose.translation = Eigen::Vector3d(0.1 * i, 0.01 * i * i, 0);
    truth.push_back(p);
    stamps.push_back(p.stamp_ns);
  }
  std::vector<Score> catalogue = ScoreEstimate(EstimateFromTrajectory(truth), truth, stamps, always).scores;
  for (Score& score : catalogue) score.value = std::numeric_limits<double>::quiet_NaN();
  return catalogue;
}

/// Maps of nothing have all scores and no value.
std::vector<Score> MapScoreCatalogue() {
  const FloorTruth truth{cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)), 1.0};
  std::vector<Score> catalogue = CompareFloor({}, truth, {}).scores;
  for (const Score& score : ComparePlaceGraph({}, {StampedPose()}).scores) catalogue.push_back(score);
  for (Score& score : catalogue) score.value = std::numeric_limits<double>::quiet_NaN();
  return catalogue;
}

}  // namespace gaitcam
