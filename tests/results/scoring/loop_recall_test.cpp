#include "results/scoring/loop_recall.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "algorithms/core/random.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

LoopDecision Right(double confidence) { return {true, confidence, true, true}; }
LoopDecision Wrong(double confidence, bool possible) { return {true, confidence, false, possible}; }
LoopDecision Silent(bool possible) { return {false, 0, false, possible}; }

TEST(LoopRecall, IsWhatOneCountsByHand) {
  // Five views could be recognised: three are, one is taken for another place, one is not answered.
  const PrecisionRecall result =
      PrecisionRecallOf({Right(7), Wrong(5, true), Right(9), Silent(true), Wrong(7, false), Right(8), Silent(false)});
  EXPECT_EQ(result.views, 7);
  EXPECT_EQ(result.possible, 5);
  ASSERT_EQ(result.curve.size(), 4u);
  const double precision[] = {1, 1, 3.0 / 4, 3.0 / 5}, recall[] = {0.2, 0.4, 0.6, 0.6}, threshold[] = {9, 8, 7, 5};
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(result.curve[k].threshold, threshold[k]);
    EXPECT_DOUBLE_EQ(result.curve[k].precision, precision[k]);
    EXPECT_DOUBLE_EQ(result.curve[k].recall, recall[k]);
  }
  EXPECT_EQ(result.curve.back().right, 3);
  EXPECT_EQ(result.curve.back().wrong, 2);
  EXPECT_DOUBLE_EQ(result.recall_at_full_precision, 0.4);
  EXPECT_DOUBLE_EQ(result.area, 0.2 * 1 + 0.2 * 1 + 0.2 * 0.75);
}

TEST(LoopRecall, OfAPerfectMethodIsOneAndOfASilentOneNothing) {
  const PrecisionRecall perfect = PrecisionRecallOf({Right(1), Right(2), Wrong(0.5, false), Silent(false)});
  EXPECT_DOUBLE_EQ(perfect.area, 1);
  EXPECT_DOUBLE_EQ(perfect.recall_at_full_precision, 1);
  const PrecisionRecall silent = PrecisionRecallOf({Silent(true), Silent(true)});
  EXPECT_TRUE(silent.curve.empty());
  EXPECT_EQ(silent.area, 0);
  EXPECT_EQ(silent.recall_at_full_precision, 0);
}

TEST(LoopRecall, WhereTheSurestAnswerIsWrongNothingIsRecalledAtFullPrecision) {
  EXPECT_EQ(PrecisionRecallOf({Wrong(9, true), Right(8), Right(7)}).recall_at_full_precision, 0);
  // As sure as the surest right one: no threshold tells them apart, in whichever order they come.
  EXPECT_EQ(PrecisionRecallOf({Right(8), Wrong(8, false)}).recall_at_full_precision, 0);
  EXPECT_EQ(PrecisionRecallOf({Wrong(8, false), Right(8)}).recall_at_full_precision, 0);
}

TEST(LoopRecall, DependsOnTheOrderOfConfidencesAlone) {
  RandomStream random(1, "decisions");
  std::vector<LoopDecision> decisions, stretched;
  for (int k = 0; k < 200; ++k) {
    const double confidence = std::round(20 * random.Uniform());
    decisions.push_back(random.Uniform() < 0.1 * confidence / 2 ? Right(confidence)
                                                                : Wrong(confidence, random.Uniform() < 0.5));
  }
  for (auto decision = decisions.rbegin(); decision != decisions.rend(); ++decision) {
    stretched.push_back(*decision);
    stretched.back().confidence = std::exp(decision->confidence) - 3;
  }
  const PrecisionRecall a = PrecisionRecallOf(decisions), b = PrecisionRecallOf(stretched);
  EXPECT_DOUBLE_EQ(a.area, b.area);
  EXPECT_DOUBLE_EQ(a.recall_at_full_precision, b.recall_at_full_precision);
  EXPECT_EQ(a.curve.size(), b.curve.size());
}

TEST(LoopRecall, WithoutAnythingToRecogniseThereIsNoScore) {
  EXPECT_THAT(ErrorOf<TooLittleData>([] {
                PrecisionRecallOf({Wrong(1, false), Silent(false)});
              }),
              HasSubstr("of no view"));
}

/// A camera that looks along the heading.
Pose At(double x_m, double y_m, double heading_deg) {
  const double heading = heading_deg * std::numbers::pi / 180;
  Eigen::Matrix3d axes;  // of the camera: right, down, ahead
  axes.col(0) = Eigen::Vector3d(std::sin(heading), -std::cos(heading), 0);
  axes.col(1) = Eigen::Vector3d(0, 0, -1);
  axes.col(2) = Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  return Pose{Eigen::Quaterniond(axes), {x_m, y_m, 1.2}};
}

TEST(LoopRecall, APlaceIsSeenAgainFromNearByAndTheSameWayRound) {
  const std::vector<Pose> views = {At(0, 0, 0),   At(3, 0, 0),      At(6, 0, 170), At(3.2, 0.5, 20),
                                   At(3, 0, 180), At(6, 0.5, -170), At(0.5, 0, 0)};
  const std::vector<LoopDecision> decisions =
      JudgeLoops({{-1, 0, 0}, {0, 1, 1}, {-1, 0, 2}, {1, 2, 3}, {1, 3, 4}, {2, 4, 5}, {-1, 5, 6}}, views);
  const auto is = [&](size_t view, bool proposed, bool right, bool possible) {
    EXPECT_EQ(decisions[view].proposed, proposed) << view;
    EXPECT_EQ(decisions[view].right, right) << view;
    EXPECT_EQ(decisions[view].possible, possible) << view;
  };
  is(0, false, false, false);
  is(1, true, false, false);  // 3 m from place 0
  is(2, false, false, false);
  is(3, true, true, true);
  is(4, true, false, false);  // where place 1 is, looking back
  is(5, true, true, true);    // 20 degrees apart, across the half turn
  is(6, false, false, true);  // place 0 is not recognised
  EXPECT_EQ(decisions[5].confidence, 4);
}

TEST(LoopRecall, OnlyPlacesThatCouldBeNamedMakeAnAnswerPossible) {
  const std::vector<Pose> views = {At(0, 0, 0), At(0.1, 0, 0), At(0.2, 0, 0)};
  EXPECT_FALSE(JudgeLoops({{-1, 0, 0}, {-1, 0, 0}, {-1, 0, 0}}, views)[2].possible);
  EXPECT_TRUE(JudgeLoops({{-1, 0, 0}, {-1, 0, 0}, {-1, 0, 1}}, views)[2].possible);
  EXPECT_THAT(ErrorOf([&] { JudgeLoops({{-1, 0, 0}}, views); }), HasSubstr("1 answers, but 3 true poses"));
  LoopTruthOptions options;
  options.same_place_m = 0;
  EXPECT_THAT(ErrorOf([&] { JudgeLoops({}, {}, options); }), HasSubstr("loops.same_place_m"));
}

}  // namespace
}  // namespace gaitcam
