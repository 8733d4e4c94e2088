#include "results/scoring/score.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "algorithms/core/errors.h"
#include "results/scoring/score_text.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Answers the frames of a walk with `estimate`'s poses, but for those in [lost_from, lost_to) and before `first`.
Estimate Answers(const Trajectory& estimate, size_t first = 0, size_t lost_from = 0, size_t lost_to = 0) {
  Estimate answers;
  for (size_t i = 0; i < estimate.size(); ++i) {
    FrameEstimate frame;
    frame.stamp_ns = estimate[i].stamp_ns;
    if (i >= first) frame.status = i >= lost_from && i < lost_to ? TrackingStatus::kLost : TrackingStatus::kTracking;
    if (frame.status == TrackingStatus::kTracking) frame.pose = estimate[i].pose;
    answers.frames.push_back(frame);
  }
  return answers;
}

const Trajectory kWalk = SwayingCircle(300, 2, 4);

TEST(Score, APerfectEstimateInAnyWorldHasNoErrors) {
  RandomStream random(1, "score");
  const Trajectory moved = Moved(RandomSimilarity(random, false), kWalk);
  const Scores s = ScoreEstimate(Answers(moved), kWalk, Stamps(kWalk), {});
  for (const char* name :
       {"ate_rmse_m", "ate_max_m", "ate_sim3_rmse_m", "rpe_trans_rmse_m_1f", "rpe_trans_rmse_m_1s",
        "rpe_trans_rmse_m_1m", "rpe_sim3_trans_rmse_m_1s", "drift_pct", "drift_sim3_pct", "end_drift_pct"}) {
    EXPECT_LT(s.Value(name), 1e-9) << name;
  }
  for (const char* name : {"ate_rot_rmse_deg", "rpe_rot_rmse_deg_1s"}) EXPECT_LT(s.Value(name), 1e-6) << name;
  EXPECT_NEAR(s.Value("scale_ratio"), 1, 1e-12);
  EXPECT_NEAR(s.Value("rotation_gain"), 1, 1e-9);
  EXPECT_EQ(s.Value("coverage_ratio"), 1);
  EXPECT_EQ(s.Value("lost_frames"), 0);
  EXPECT_TRUE(s.remarks.empty());
}

TEST(Score, AWrongScaleIsForgivenUnderSim3OnlyAndStated) {
  Similarity doubled;
  doubled.scale = 2;
  const Scores s = ScoreEstimate(Answers(Moved(doubled, kWalk)), kWalk, Stamps(kWalk), {});
  EXPECT_NEAR(s.Value("scale_ratio"), 2, 1e-12);
  EXPECT_NEAR(s.Value("scale_error_pct"), 100, 1e-9);
  EXPECT_LT(s.Value("ate_sim3_rmse_m"), 1e-9);
  EXPECT_GT(s.Value("ate_rmse_m"), 1);
  EXPECT_LT(s.Value("drift_sim3_pct"), 1e-9);
  EXPECT_GT(s.Value("drift_pct"), 50);
  EXPECT_LT(std::abs(s.Value("scale_drift_pct_per_m")), 1e-6);
}

TEST(Score, BothAlignmentsComeWithTheirPathsAndErrors) {
  const Scores s = ScoreEstimate(Answers(kWalk, 10, 100, 130), kWalk, Stamps(kWalk), {});
  EXPECT_EQ(s.last.pairs.size(), 260u);
  for (const size_t size : {s.last.aligned_se3.size(), s.last.aligned_sim3.size(), s.last.error_se3_m.size(),
                            s.last.error_sim3_m.size(), s.last.error_rot_deg.size()}) {
    EXPECT_EQ(size, 260u);
  }
  EXPECT_LT((s.last.aligned_sim3.back().pose.translation - kWalk.back().pose.translation).norm(), 1e-9);
}

TEST(Score, CoverageCountsWhatHasNoPose) {
  const Scores s = ScoreEstimate(Answers(kWalk, 30, 100, 145), kWalk, Stamps(kWalk), {});
  EXPECT_DOUBLE_EQ(s.Value("coverage_ratio"), 0.75);
  EXPECT_EQ(s.Value("frames"), 300);
  EXPECT_EQ(s.Value("tracked_frames"), 225);
  EXPECT_EQ(s.Value("initializing_frames"), 30);
  EXPECT_EQ(s.Value("lost_frames"), 45);
  EXPECT_NEAR(s.Value("time_to_first_pose_s"), 1, 1e-6);
  ASSERT_EQ(s.remarks.size(), 1u);
  EXPECT_THAT(s.remarks[0], HasSubstr("75.0 %"));
}

TEST(Score, FramesThatTheSystemNeverAnsweredAreNotCovered) {
  Trajectory half(kWalk.begin(), kWalk.begin() + 150);
  const Scores s = ScoreEstimate(Answers(half), kWalk, Stamps(kWalk), {});
  EXPECT_DOUBLE_EQ(s.Value("coverage_ratio"), 0.5);
  EXPECT_EQ(s.Value("lost_frames"), 150);
}

TEST(Score, TooFewPairsAreNoScore) {
  const Trajectory brief(kWalk.begin(), kWalk.begin() + 10), briefer(kWalk.begin(), kWalk.begin() + 9);
  EXPECT_NO_THROW(ScoreEstimate(Answers(brief), brief, Stamps(brief), {}));
  EXPECT_THROW(ScoreEstimate(Answers(briefer), briefer, Stamps(briefer), {}), TooLittleData);
  EXPECT_THROW(ScoreEstimate({}, kWalk, Stamps(kWalk), {}), TooLittleData);
  EXPECT_THROW(ScoreEstimate({}, {}, {}, {}), TooLittleData);
}

TEST(Score, TooLittleCoverageIsNoScore) {
  ScoreOptions options;
  options.min_coverage_ratio = 0.5;
  EXPECT_NO_THROW(ScoreEstimate(Answers(kWalk, 150), kWalk, Stamps(kWalk), options));
  EXPECT_THROW(ScoreEstimate(Answers(kWalk, 151), kWalk, Stamps(kWalk), options), TooLittleData);
}

TEST(Score, StampsFromAnotherClockAreNoScoreAndTheTextSaysWhy) {
  Trajectory elsewhere = kWalk;
  for (StampedPose& p : elsewhere) p.stamp_ns += 1'000'000'000'000;
  try {
    ScoreEstimate(Answers(elsewhere), kWalk, Stamps(kWalk), {});
    FAIL();
  } catch (const TooLittleData& error) {
    EXPECT_THAT(error.what(), HasSubstr("0 poses of the estimate (300 in all) have a true pose within 10 ms"));
  }
}

TEST(Score, WhatASystemSaysOfARestartChangesNoOtherScore) {
  Estimate answers = Answers(kWalk);
  const double before = ScoreEstimate(answers, kWalk, Stamps(kWalk), {}).Value("ate_sim3_rmse_m");
  for (size_t i = 150; i < 300; ++i) answers.frames[i].pose->translation *= 0.3;
  const Scores silent = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  answers.frames[150].restarted = true;
  const Scores said = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  EXPECT_EQ(said.Value("restarts"), 1);
  EXPECT_EQ(silent.Value("jumps"), 1);
  EXPECT_GT(said.Value("ate_sim3_rmse_m"), before + 0.1);
  EXPECT_THAT(said.remarks, testing::Contains(HasSubstr("chose its world anew 1 time;")));
  for (size_t k = 0; k < said.scores.size(); ++k) {
    if (said.scores[k].name == "restarts" || std::isnan(said.scores[k].value)) continue;
    EXPECT_EQ(said.scores[k].value, silent.scores[k].value) << said.scores[k].name;
  }
}

TEST(Score, InliersAreAShareOfTheMatchesOfFramesWithAPose) {
  Estimate answers = Answers(kWalk);
  EXPECT_TRUE(std::isnan(ScoreEstimate(answers, kWalk, Stamps(kWalk), {}).Value("inlier_ratio"))) << "none are told";
  for (size_t i = 0; i < answers.frames.size(); ++i) {
    answers.frames[i].matches = 200;
    answers.frames[i].inliers = i % 2 == 0 ? 100 : 150;
  }
  answers.frames[7].matches = 0;  // not told of one frame: the ratio is of the others
  answers.frames[8].inliers = 0;  // and a frame without a pose has none
  answers.frames[8].pose.reset();
  answers.frames[8].status = TrackingStatus::kLost;
  EXPECT_NEAR(ScoreEstimate(answers, kWalk, Stamps(kWalk), {}).Value("inlier_ratio"), 0.625, 1e-12);
}

// Live it was lost for 50 frames, and noisy; finally all is known.
TEST(Score, BothAnswersAreScoredByTheSameMeasures) {
  RandomStream random(3, "live");
  Estimate answers = Answers(kWalk);
  answers.live = Answers(Noisy(kWalk, random, 0.004, 0.002), 0, 100, 150).frames;
  const Scores s = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  EXPECT_EQ(s.Value("coverage_ratio"), 1);
  EXPECT_NEAR(s.Value("live_coverage_ratio"), 250.0 / 300, 1e-12);
  EXPECT_EQ(s.Value("live_lost_frames"), 50);
  EXPECT_LT(s.Value("ate_rmse_m"), 1e-9);
  EXPECT_NEAR(s.Value("live_ate_rmse_m"), 0.004 * std::sqrt(3), 0.0008);  // 750 coordinates: 4 standard errors
  ASSERT_TRUE(s.live.has_value());
  EXPECT_EQ(s.live->pairs.size(), 250u);
  // The same answer has the same scores, whichever it is.
  answers.live = answers.frames;
  const Scores same = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  int compared = 0;
  for (const Score& score : same.scores) {
    if (!score.name.starts_with("live_") || std::isnan(score.value)) continue;
    EXPECT_EQ(score.value, same.Value(score.name.substr(5))) << score.name;
    ++compared;
  }
  EXPECT_GT(compared, 40);
}

TEST(Score, WithoutALiveAnswerThereAreNoLiveScores) {
  const Scores s = ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), {});
  EXPECT_THROW(s.Value("live_coverage_ratio"), BadInput);
}

TEST(Score, ALiveAnswerThatCoversNextToNothingHasItsCoverageOnly) {
  Estimate answers = Answers(kWalk);
  answers.live = Answers(kWalk, 295).frames;
  const Scores s = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  EXPECT_NEAR(s.Value("live_coverage_ratio"), 5.0 / 300, 1e-12);
  EXPECT_TRUE(std::isnan(s.Value("live_ate_rmse_m")));
  EXPECT_TRUE(std::isnan(s.Value("live_rpe_trans_rmse_m_1s")));
}

TEST(Score, TheFirstWorldIsNoRestart) {
  Estimate answers = Answers(kWalk, 5);
  answers.frames[5].restarted = true;
  EXPECT_EQ(ScoreEstimate(answers, kWalk, Stamps(kWalk), {}).Value("restarts"), 0);
}

TEST(Score, TwoFilesAreComparedByTheTimeTheyShare) {
  // Nobody knows of frames: half of the true time span is covered, at a third of the truth's rate.
  Trajectory sparse;
  for (size_t i = 0; i < 150; i += 3) sparse.push_back(kWalk[i]);
  const Scores s = ScoreEstimate(EstimateFromTrajectory(sparse), kWalk, {}, {});
  EXPECT_NEAR(s.Value("coverage_ratio"), 147.0 / 299, 1e-9);
  EXPECT_EQ(s.Value("pairs"), 50);
  EXPECT_THROW(s.Value("lost_frames"), BadInput);
}

TEST(Score, AGapInAFileIsNotCovered) {
  Trajectory gap = kWalk;
  gap.erase(gap.begin() + 100, gap.begin() + 200);
  EXPECT_NEAR(ScoreEstimate(EstimateFromTrajectory(gap), kWalk, {}, {}).Value("coverage_ratio"), 198.0 / 299, 1e-9);
}

TEST(Score, FurtherAlignmentsStandWhenAskedFor) {
  ScoreOptions options;
  options.also_align = AlsoAlign::kBoth;
  Similarity shift;
  shift.translation = {0, 3, 4};
  const Scores s = ScoreEstimate(Answers(Moved(shift, kWalk)), kWalk, Stamps(kWalk), options);
  EXPECT_NEAR(s.Value("ate_none_rmse_m"), 5, 1e-9);
  EXPECT_LT(s.Value("ate_yaw_rmse_m"), 1e-9);
  EXPECT_LT(s.Value("ate_none_rot_rmse_deg"), 1e-9);
  EXPECT_THROW(ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), {}).Value("ate_none_rmse_m"), BadInput);
}

TEST(Score, PositionsThatMisleadTheAlignmentAreRemarkedUpon) {
  // Positions turned by 100 degrees about the path's own axes, orientations right: the two alignments cannot agree.
  Trajectory twisted = kWalk;
  for (StampedPose& p : twisted) p.pose.translation = RotZ(100 * std::numbers::pi / 180) * p.pose.translation;
  const Scores s = ScoreEstimate(Answers(twisted), kWalk, Stamps(kWalk), {});
  EXPECT_NEAR(s.Value("ate_rot_rmse_deg"), 100, 1e-6);
  EXPECT_LT(s.Value("ate_rot_own_rmse_deg"), 1e-6);
  ASSERT_EQ(s.remarks.size(), 1u);
  EXPECT_THAT(s.remarks[0], HasSubstr("100 deg"));
}

TEST(Score, IntervalsNameTheirScores) {
  ScoreOptions options;
  options.rpe_frames = 5;
  options.rpe_seconds = 0.5;
  options.rpe_meters = 2;
  const Scores s = ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), options);
  for (const char* name : {"rpe_trans_rmse_m_5f", "rpe_rot_rmse_deg_0.5s", "rpe_sim3_trans_median_m_2m"}) {
    EXPECT_LT(s.Value(name), 1e-6) << name;
  }
}

TEST(Score, WhatARunDoesNotDetermineIsNotANumber) {
  const Trajectory brief(kWalk.begin(), kWalk.begin() + 20);  // 0.6 s: neither a second nor a metre nor a turn
  const Scores s = ScoreEstimate(Answers(brief), brief, Stamps(brief), {});
  for (const char* name : {"rpe_trans_rmse_m_1s", "rpe_trans_rmse_m_1m", "rotation_gain"}) {
    EXPECT_TRUE(std::isnan(s.Value(name))) << name;
  }
  EXPECT_THAT(ScoresToJson(s), HasSubstr("\"rotation_gain\": null"));
}

TEST(Score, EveryScoreHasItsOwnNameAndAMeaning) {
  ScoreOptions options;
  options.also_align = AlsoAlign::kBoth;
  Estimate answers = Answers(kWalk);
  answers.track_ms.assign(300, 20);
  const Scores s = ScoreEstimate(answers, kWalk, Stamps(kWalk), options);
  std::set<std::string> names;
  for (const auto* list : {&s.scores, &s.timing}) {
    for (const Score& score : *list) {
      EXPECT_TRUE(names.insert(score.name).second) << score.name;
      EXPECT_NE(score.meaning, "") << score.name;
      EXPECT_EQ(score.name.find(' '), std::string::npos) << score.name;
    }
  }
  EXPECT_GT(names.size(), 60u);
}

TEST(Score, AnUnknownNameIsToldTheNearest) {
  const Scores s = ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), {});
  try {
    s.Value("ate_rmse");
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean ate_rmse_m?"));
  }
}

TEST(Score, OptionsOutOfRangeAreRefused) {
  ScoreOptions options;
  options.rpe_seconds = 0;
  EXPECT_THROW(ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), options), BadOption);
  options = {};
  options.association.max_difference_ms = -1;
  EXPECT_THROW(ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), options), BadOption);
}

TEST(ScoresJson, DiffersBetweenRunsInTimingAlone) {
  RandomStream random(2, "score");
  const Trajectory noisy = Noisy(kWalk, random, 0.01, 0.01);
  Estimate a = Answers(noisy), b = a;
  for (size_t i = 0; i < 300; ++i) {
    a.track_ms.push_back(10 + double(i));
    b.track_ms.push_back(20);
  }
  const std::string first = ScoresToJson(ScoreEstimate(a, kWalk, Stamps(kWalk), {}));
  const std::string second = ScoresToJson(ScoreEstimate(b, kWalk, Stamps(kWalk), {}));
  EXPECT_NE(first, second);
  EXPECT_EQ(first.substr(0, first.find("\"timing\"")), second.substr(0, second.find("\"timing\"")));
}

TEST(ScoresJson, HoldsEveryScoreToTheLastBit) {
  RandomStream random(3, "score");
  Estimate answers = Answers(Noisy(kWalk, random, 0.01, 0.01));
  answers.track_ms.assign(300, 12.5);
  const Scores s = ScoreEstimate(answers, kWalk, Stamps(kWalk), {});
  const auto json = nlohmann::ordered_json::parse(ScoresToJson(s));
  EXPECT_EQ(json["schema"], "gaitcam.scores.1");
  ASSERT_EQ(json["scores"].size(), s.scores.size());
  size_t i = 0;
  for (const auto& [name, value] : json["scores"].items()) {
    EXPECT_EQ(name, s.scores[i].name);  // in order
    const double number = value.is_null() ? std::nan("") : value.get<double>();
    EXPECT_TRUE(number == s.scores[i].value || (std::isnan(number) && std::isnan(s.scores[i].value))) << name;
    ++i;
  }
  EXPECT_EQ(json["timing"]["track_ms_mean"], 12.5);
  EXPECT_EQ(json["alignment"]["sim3"]["scale"].get<double>(), s.last.sim3.X_WV.scale);
  EXPECT_EQ(json["alignment"]["se3"]["rotation_xyzw"].size(), 4u);
}

TEST(ScoresTable, ColumnsStandUnderEachOther) {
  const Scores s = ScoreEstimate(Answers(kWalk), kWalk, Stamps(kWalk), {});
  std::istringstream lines(ScoresToTable(s));
  std::set<size_t> columns;
  for (const Score& score : s.scores) {
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line.rfind(score.name, 0), 0u);
    columns.insert(line.find(score.meaning));
  }
  EXPECT_EQ(columns.size(), 1u);
}

TEST(ScoreText, HasFourDigitsAndCountsInFull) {
  EXPECT_EQ(ScoreText(0.0123456), "0.01235");
  EXPECT_EQ(ScoreText(12.3456), "12.35");
  EXPECT_EQ(ScoreText(12345.678), "12346");
  EXPECT_EQ(ScoreText(123456), "123456");
  EXPECT_EQ(ScoreText(0), "0");
  EXPECT_EQ(ScoreText(-1.5), "-1.500");
  EXPECT_EQ(ScoreText(1.5e-12), "1.500e-12");
  EXPECT_EQ(ScoreText(std::nan("")), "-");
}

}  // namespace
}  // namespace gaitcam
