#include "results/scoring/association.h"

#include <gtest/gtest.h>

#include <set>

#include "algorithms/core/errors.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

constexpr int64_t kMs = 1'000'000;

std::vector<int64_t> Milliseconds(std::vector<double> stamps) {
  std::vector<int64_t> ns;
  for (const double s : stamps) ns.push_back(std::llround(s * kMs));
  return ns;
}

AssociationOptions Within(double max_difference_ms, AssociationRule rule = AssociationRule::kOneToOne) {
  AssociationOptions options;
  options.rule = rule;
  options.max_difference_ms = max_difference_ms;
  return options;
}

using Pairs = std::vector<IndexPair>;

TEST(Association, EqualStampsPairOff) {
  const auto stamps = Milliseconds({0, 33, 66});
  EXPECT_EQ(Associate(stamps, stamps, Within(0)), (Pairs{{0, 0}, {1, 1}, {2, 2}}));
}

TEST(Association, TheToleranceItselfIsPermittedAndANanosecondMoreIsNot) {
  EXPECT_EQ(Associate({10 * kMs}, {0}, Within(10)).size(), 1u);
  EXPECT_EQ(Associate({10 * kMs + 1}, {0}, Within(10)).size(), 0u);
  EXPECT_EQ(Associate({10 * kMs}, {0}, Within(10, AssociationRule::kNearest)).size(), 1u);
  EXPECT_EQ(Associate({10 * kMs + 1}, {0}, Within(10, AssociationRule::kNearest)).size(), 0u);
}

TEST(Association, TheOffsetIsAddedToTheEstimate) {
  AssociationOptions options = Within(1);
  options.time_offset_ms = 500;
  EXPECT_EQ(Associate(Milliseconds({500, 600}), Milliseconds({0, 100}), options), (Pairs{{0, 0}, {1, 1}}));
  options.rule = AssociationRule::kNearest;
  EXPECT_EQ(Associate(Milliseconds({500, 600}), Milliseconds({0, 100}), options), (Pairs{{0, 0}, {1, 1}}));
}

TEST(Association, TwoEstimatesNearOneTruthGiveOnePairOnly) {
  // Both estimates lie within reach of the one true pose: the nearer gets it, the other stays alone.
  EXPECT_EQ(Associate(Milliseconds({100}), Milliseconds({95, 101}), Within(10)), (Pairs{{0, 1}}));
}

TEST(Association, NearestTakesALongerListsEntryTwice) {
  // Three estimates against four true poses: the shorter list asks, and two of it are nearest to the pose at 10 ms.
  const auto pairs =
      Associate(Milliseconds({0, 10, 50, 60}), Milliseconds({8, 12, 51}), Within(5, AssociationRule::kNearest));
  EXPECT_EQ(pairs, (Pairs{{1, 0}, {1, 1}, {2, 2}}));
  EXPECT_EQ(Associate(Milliseconds({0, 10, 50, 60}), Milliseconds({8, 12, 51}), Within(5)).size(), 2u);
}

TEST(Association, NearestTakesTheEarlierOfTwoEquallyNear) {
  EXPECT_EQ(Associate(Milliseconds({0, 10}), Milliseconds({5}), Within(10, AssociationRule::kNearest)),
            (Pairs{{0, 0}}));
}

TEST(Association, AMissingStampDoesNotShiftItsNeighbours) {
  // The truth lacks the stamp at 50 ms and has one before the start. Pairing every estimate with the stamp before its
  // own would give one pair more, each 9.9 ms off; the five good pairs must win.
  const auto truth = Milliseconds({-9.9, 0.1, 10.1, 20.1, 30.1, 40.1});
  const auto estimate = Milliseconds({0, 10, 20, 30, 40, 50});
  EXPECT_EQ(Associate(truth, estimate, Within(10)), (Pairs{{1, 0}, {2, 1}, {3, 2}, {4, 3}, {5, 4}}));
}

TEST(Association, NoPosePairsTwiceAndPairsNeverCross) {
  RandomStream random(3, "association");
  for (int run = 0; run < 200; ++run) {
    std::vector<int64_t> truth = {0}, estimate = {random.Index(20)};
    for (int i = 0; i < 60; ++i) truth.push_back(truth.back() + 1 + random.Index(20));
    for (int i = 0; i < 50; ++i) estimate.push_back(estimate.back() + 1 + random.Index(25));
    AssociationOptions options = Within(8e-6);  // 8 ns
    const Pairs pairs = Associate(truth, estimate, options);
    for (size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_LE(std::abs(truth[pairs[k].truth] - estimate[pairs[k].estimate]), 8);
      if (k == 0) continue;
      EXPECT_GT(pairs[k].truth, pairs[k - 1].truth);
      EXPECT_GT(pairs[k].estimate, pairs[k - 1].estimate);
    }
  }
}

/// The best total by trying every choice: a pair is taken or one of its two stamps is passed over.
int64_t BestGain(const std::vector<int64_t>& a, const std::vector<int64_t>& b, size_t i, size_t j, int64_t tolerance) {
  if (i == a.size() || j == b.size()) return 0;
  int64_t best = std::max(BestGain(a, b, i + 1, j, tolerance), BestGain(a, b, i, j + 1, tolerance));
  const int64_t gain = tolerance - std::abs(a[i] - b[j]);
  if (gain >= 0) best = std::max(best, gain + BestGain(a, b, i + 1, j + 1, tolerance));
  return best;
}

TEST(Association, TheChoiceIsTheBestOfAll) {
  RandomStream random(4, "association");
  for (int run = 0; run < 100; ++run) {
    std::vector<int64_t> truth = {random.Index(9)}, estimate = {random.Index(9)};
    for (int i = 0; i < 5; ++i) truth.push_back(truth.back() + 1 + random.Index(9));
    for (int i = 0; i < 5; ++i) estimate.push_back(estimate.back() + 1 + random.Index(9));
    int64_t gain = 0;
    for (const IndexPair& p : Associate(truth, estimate, Within(6e-6))) {
      gain += 6 - std::abs(truth[p.truth] - estimate[p.estimate]);
    }
    EXPECT_EQ(gain, BestGain(truth, estimate, 0, 0, 6));
  }
}

std::vector<FrameEstimate> LateBy(int64_t late_ns, const Trajectory& walk) {
  std::vector<FrameEstimate> answer;
  for (const StampedPose& p : walk) {
    FrameEstimate frame;
    frame.stamp_ns = p.stamp_ns;
    frame.pose = p.pose;
    frame.pose_delay_ns = late_ns;
    answer.push_back(frame);
  }
  return answer;
}

TEST(Association, PosesAreComparedAtTheirOwnInstant) {
  const Trajectory walk = SwayingCircle(60, 1, 3);
  // The last pose lies beyond the truth and finds no partner within 10 ms.
  const std::vector<PosePair> late = AssociatePoses(LateBy(12'000'000, walk), walk, {});
  ASSERT_EQ(late.size(), 59u);
  for (size_t k = 0; k < late.size(); ++k) {
    EXPECT_EQ(late[k].stamp_ns, walk[k].stamp_ns + 12'000'000);
    EXPECT_GT((late[k].truth.translation - walk[k].pose.translation).norm(), 0.005) << k;  // the camera went on
  }
  const std::vector<PosePair> exact = AssociatePoses(LateBy(0, walk), walk, {});
  ASSERT_EQ(exact.size(), 60u);
  for (size_t k = 0; k < exact.size(); ++k) EXPECT_EQ(exact[k].truth.translation, walk[k].pose.translation);
}

TEST(Association, WhereTheTruthHasAGapNothingIsInterpolated) {
  const Trajectory walk = SwayingCircle(60, 1, 3);
  Trajectory truth = walk;
  truth.erase(truth.begin() + 20, truth.begin() + 26);  // 233 ms
  EXPECT_EQ(AssociatePoses(LateBy(0, walk), truth, {}).size(), 54u);
  AssociationOptions wide;
  wide.max_gap_ms = 300;
  EXPECT_EQ(AssociatePoses(LateBy(0, walk), truth, wide).size(), 60u);
}

TEST(Association, StampsThatGoBackAreRefused) {
  Trajectory walk = SwayingCircle(3, 1, 1);
  std::swap(walk[1], walk[2]);
  EXPECT_THROW(AssociatePoses({}, walk, {}), BadInput);
}

TEST(Association, AnUnknownRuleIsRefused) { EXPECT_THROW(Associate({}, {}, Within(1, AssociationRule(7))), BadOption); }

}  // namespace
}  // namespace gaitcam
