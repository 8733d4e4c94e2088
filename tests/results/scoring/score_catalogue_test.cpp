#include "results/scoring/score_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "results/scoring/drive_score.h"
#include "results/scoring/floor_pose.h"
#include "results/scoring/floor_score.h"
#include "results/scoring/place_graph_score.h"
#include "results/scoring/pose_graph_score.h"
#include "results/scoring/route_map_score.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

/// Everything but the value.
std::vector<std::string> Described(const std::vector<Score>& scores) {
  std::vector<std::string> lines;
  for (const Score& s : scores) {
    lines.push_back(s.name + "|" + s.unit + "|" + s.meaning + "|" + std::to_string(int(s.better)) + "|" +
                    Title(s.group) + (s.headline ? "|headline" : ""));
  }
  return lines;
}

TEST(ScoreCatalogue, IsWhatARunIsScoredBy) {
  ScoreOptions options;
  options.also_align = AlsoAlign::kBoth;
  options.rpe_meters = 0.5;
  const Trajectory walk = SwayingCircle(100, 2, 4);
  Estimate estimate = EstimateFromTrajectory(walk);
  estimate.live = estimate.frames;
  const Scores scores = ScoreEstimate(estimate, walk, Stamps(walk), options);
  EXPECT_THAT(Described(scores.scores), testing::ElementsAreArray(Described(ScoreCatalogue(options))));
}

TEST(ScoreCatalogue, OfMapsIsWhatMapsAreScoredBy) {
  const FloorTruth truth{cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)), 1.0};
  std::vector<Score> scores = CompareFloor({}, truth, {}).scores;
  for (const Score& score : Evaluate(FloorPoseMetrics(), MeasureFloorPoses({}))) scores.push_back(score);
  for (const Score& score : ComparePlaceGraph({}, {StampedPose()}).scores) scores.push_back(score);
  for (const Score& score : ComparePoseGraph({}, {StampedPose()}).scores) scores.push_back(score);
  for (const Score& score : CompareRouteMap({}, {StampedPose()}).scores) scores.push_back(score);
  const Trajectory nowhere;
  const PeopleAt nobody = [](int64_t) { return std::vector<Eigen::Vector2d>(); };
  for (const Score& score : CompareDrive({}, {nowhere, nowhere, nobody}).scores) scores.push_back(score);
  EXPECT_THAT(Described(scores), testing::ElementsAreArray(Described(MapScoreCatalogue())));
}

TEST(ScoreCatalogue, HasEachNameOnceWithItsMeaning) {
  std::vector<Score> all = ScoreCatalogue({});
  for (const Score& score : MapScoreCatalogue()) all.push_back(score);
  std::set<std::string> names;
  for (const Score& score : all) {
    EXPECT_TRUE(names.insert(score.name).second) << score.name;
    EXPECT_FALSE(score.meaning.empty()) << score.name;
  }
}

TEST(ScoreCatalogue, HeadlinesAreFewAndOfEveryKind) {
  std::multiset<ScoreGroup> groups;
  for (const Score& score : ScoreCatalogue({})) {
    if (score.headline && !score.name.starts_with("live_")) groups.insert(score.group);
  }
  const size_t of_consistency = groups.count(ScoreGroup::kConsistency);  // printed of systems that state covariances
  EXPECT_LE(of_consistency, 3u);
  // Live ones stand in the same lines; with time per frame and those of one map, a dozen lines.
  EXPECT_LE(groups.size() - of_consistency, 9u);
  for (const ScoreGroup group :
       {ScoreGroup::kCoverage, ScoreGroup::kAbsolute, ScoreGroup::kDrift, ScoreGroup::kScale, ScoreGroup::kRotation}) {
    EXPECT_GE(groups.count(group), 1u) << Title(group);
  }
}

TEST(ScoreCatalogue, KnowsTheScoresOfMaps) {
  int loops = 0;
  for (const Score& score : MapScoreCatalogue()) {
    loops += score.name == "loops_false" && score.better == Better::kLower;
    EXPECT_THAT(score.name, testing::MatchesRegex("(map|place|graph|route|drive|loops?)_.*"));
    EXPECT_TRUE(std::isnan(score.value)) << score.name;
    if (score.name == "map_ncc") {
      EXPECT_EQ(score.better, Better::kHigher);
    }
    if (score.name == "map_landmark_error_median_m") {
      EXPECT_EQ(score.better, Better::kLower);
    }
  }
  EXPECT_EQ(loops, 1);
  EXPECT_GE(MapScoreCatalogue().size(), 8u);
}

TEST(ScoreCatalogue, KnowsNamesDirectionsAndTheIntervalsAskedFor) {
  ScoreOptions options;
  options.rpe_seconds = 2;
  options.min_pairs = 1000;
  const auto better_of = [&](const std::string& name) {
    for (const Score& score : ScoreCatalogue(options)) {
      if (score.name == name) return score.better;
    }
    ADD_FAILURE() << name;
    return Better::kNeither;
  };
  EXPECT_EQ(better_of("ate_sim3_rmse_m"), Better::kLower);
  EXPECT_EQ(better_of("coverage_ratio"), Better::kHigher);
  EXPECT_EQ(better_of("rotation_gain"), Better::kNearOne);
  EXPECT_EQ(better_of("scale_error_pct"), Better::kNearZero);
  EXPECT_EQ(better_of("path_length_m"), Better::kNeither);
  EXPECT_EQ(better_of("rpe_rot_rmse_deg_2s"), Better::kLower);
}

}  // namespace
}  // namespace gaitcam
