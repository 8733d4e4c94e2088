#include "results/scoring/alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "results/scoring/metrics.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

double Rmse(const AlignmentResult& alignment, const std::vector<PosePair>& pairs) {
  return Summarize(PositionErrors(Apply(alignment.X_WV, pairs))).rmse;
}

TEST(Alignment, UndoesARandomSimilarity) {
  RandomStream random(1, "alignment");
  const Trajectory truth = SwayingCircle(100, 2, 3);
  for (int run = 0; run < 100; ++run) {
    const Similarity X = RandomSimilarity(random, true);
    const std::vector<PosePair> pairs = PairUp(truth, Moved(X, truth));
    const AlignmentResult found = Align(pairs, Alignment::kSim3);
    // Rounding: positions are of size 10, doubles have 16 digits, and the z extent is 500 times smaller than the rest.
    EXPECT_NEAR(found.X_WV.scale * X.scale, 1, 1e-11);
    EXPECT_LT(RotationAngle(found.X_WV.rotation, X.rotation.conjugate()), 1e-9);
    EXPECT_LT(Rmse(found, pairs), 1e-10);
    EXPECT_EQ(found.rank, 3);
    EXPECT_EQ(found.Remark(), "");
  }
}

TEST(Alignment, UndoesARandomRigidMotion) {
  RandomStream random(2, "alignment");
  const Trajectory truth = SwayingCircle(100, 2, 3);
  for (int run = 0; run < 100; ++run) {
    const std::vector<PosePair> pairs = PairUp(truth, Moved(RandomSimilarity(random, false), truth));
    EXPECT_LT(Rmse(Align(pairs, Alignment::kSe3), pairs), 1e-10);
  }
}

TEST(Alignment, YawUndoesATurnAboutTheVerticalButNoTilt) {
  const Trajectory truth = SwayingCircle(100, 2, 3);
  Similarity turn, tilt;
  turn.rotation = RotZ(2.5);
  turn.translation = {1, -2, 3};
  tilt.rotation = RotX(0.1);
  const auto turned = PairUp(truth, Moved(turn, truth)), tilted = PairUp(truth, Moved(tilt, truth));
  EXPECT_LT(Rmse(Align(turned, Alignment::kYaw), turned), 1e-12);
  EXPECT_GT(Rmse(Align(tilted, Alignment::kYaw), tilted), 0.01);
  EXPECT_LT(Rmse(Align(tilted, Alignment::kSe3), tilted), 1e-12);
}

TEST(Alignment, NoneLeavesTheEstimateAlone) {
  const Trajectory truth = SwayingCircle(10, 2, 3);
  Similarity shift;
  shift.translation = {3, 4, 0};
  const auto pairs = PairUp(truth, Moved(shift, truth));
  EXPECT_NEAR(Rmse(Align(pairs, Alignment::kNone), pairs), 5, 1e-14);
}

TEST(Alignment, NoOtherRigidMotionIsBetter) {
  RandomStream random(3, "alignment");
  const Trajectory truth = SwayingCircle(60, 1, 4);
  const auto pairs = PairUp(truth, Noisy(Moved(RandomSimilarity(random, true), truth), random, 0.1, 0));
  for (const Alignment kind : {Alignment::kSe3, Alignment::kSim3}) {
    const AlignmentResult best = Align(pairs, kind);
    const double least = Rmse(best, pairs);
    for (int k = 0; k < 300; ++k) {
      AlignmentResult other = best;
      const Eigen::Vector3d w(random.Normal(), random.Normal(), random.Normal());
      other.X_WV.rotation = other.X_WV.rotation * Eigen::AngleAxisd(0.02 * w.norm(), w.normalized());
      other.X_WV.translation += 0.02 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
      if (kind == Alignment::kSim3) other.X_WV.scale *= std::exp(0.02 * random.Normal());
      EXPECT_GE(Rmse(other, pairs), least);
    }
  }
}

TEST(Alignment, AMirroredPathIsNotMirroredBack) {
  // A reflection would fit perfectly; a rotation must not, and must stay a rotation.
  RandomStream random(4, "alignment");
  std::vector<PosePair> pairs(20);
  for (PosePair& p : pairs) {
    p.truth.translation = {random.Normal(), random.Normal(), random.Normal()};
    p.estimate.translation = p.truth.translation.cwiseProduct(Eigen::Vector3d(1, 1, -1));
  }
  const AlignmentResult found = Align(pairs, Alignment::kSim3);
  EXPECT_NEAR(found.X_WV.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  EXPECT_GT(Rmse(found, pairs), 0.1);
}

Trajectory StraightLine(int frames) {
  Trajectory line;
  for (int i = 0; i < frames; ++i) line.push_back({i * kFrame_ns, Pose(LookAlong(0.02 * i), {0.01 * i, 0, 0.3})});
  return line;
}

TEST(Alignment, OnALineTheOrientationsDecideTheRollThatPositionsLeaveFree) {
  RandomStream random(5, "alignment");
  const Trajectory truth = StraightLine(50);
  for (int run = 0; run < 50; ++run) {
    const auto pairs = PairUp(truth, Moved(RandomSimilarity(random, true), truth));
    const AlignmentResult found = Align(pairs, Alignment::kSim3);
    EXPECT_EQ(found.rank, 1);
    EXPECT_THAT(found.Remark(), testing::HasSubstr("line"));
    EXPECT_LT(Rmse(found, pairs), 1e-10);
    for (const double error : RotationErrors(Apply(found.X_WV, pairs))) EXPECT_LT(error, 1e-7);
  }
}

TEST(Alignment, WithoutAnyExtentTheOrientationsDecideAndScaleStaysOne) {
  RandomStream random(6, "alignment");
  Trajectory truth;  // turns on the spot
  for (int i = 0; i < 50; ++i) truth.push_back({i * kFrame_ns, Pose(LookAlong(0.1 * i), {1, 2, 0.3})});
  for (const Alignment kind : {Alignment::kSe3, Alignment::kSim3}) {
    const auto pairs = PairUp(truth, Moved(RandomSimilarity(random, false), truth));
    const AlignmentResult found = Align(pairs, kind);
    EXPECT_EQ(found.rank, 0);
    EXPECT_FALSE(found.scale_known);
    EXPECT_EQ(found.X_WV.scale, 1);
    EXPECT_THAT(found.Remark(), testing::HasSubstr("orientations"));
    EXPECT_LT(Rmse(found, pairs), 1e-12);
    for (const double error : RotationErrors(Apply(found.X_WV, pairs))) EXPECT_LT(error, 1e-7);
  }
}

TEST(Alignment, AnEstimateThatWandersWhileTheTruthStandsIsNotScaledAway) {
  // Scale 0 would make the error vanish: the perfect score of an estimate that is all wrong.
  const Trajectory walk = SwayingCircle(50, 1, 3);
  Trajectory truth = walk;
  for (StampedPose& p : truth) p.pose.translation = {1, 1, 1};
  const auto pairs = PairUp(truth, walk);
  const AlignmentResult found = Align(pairs, Alignment::kSim3);
  EXPECT_FALSE(found.scale_known);
  EXPECT_GT(Rmse(found, pairs), 0.5);
}

TEST(Alignment, AnEstimateThatNeverMovedIsPlacedInTheMiddle) {
  const Trajectory truth = SwayingCircle(50, 1, 3);
  Trajectory stuck = truth;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (StampedPose& p : stuck) {
    mean += p.pose.translation / 50;
    p.pose.translation = {7, 7, 7};
  }
  double squares = 0;
  for (const StampedPose& p : truth) squares += (p.pose.translation - mean).squaredNorm() / 50;
  const auto pairs = PairUp(truth, stuck);
  for (const Alignment kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kYaw}) {
    EXPECT_NEAR(Rmse(Align(pairs, kind), pairs), std::sqrt(squares), 1e-12) << ToString(kind);
  }
}

TEST(Alignment, OrientationsAloneFindTheRotationOfAnyWorld) {
  RandomStream random(7, "alignment");
  const Trajectory truth = SwayingCircle(50, 1, 3);
  for (int run = 0; run < 20; ++run) {
    const Similarity X = RandomSimilarity(random, true);
    Trajectory estimate = Moved(X, truth);
    for (StampedPose& p : estimate) p.pose.translation = {random.Normal(), random.Normal(), random.Normal()};
    EXPECT_LT(RotationAngle(AlignOrientations(PairUp(truth, estimate)), X.rotation.conjugate()), 1e-12);
  }
}

TEST(Alignment, YawOfAPurelyVerticalPathComesFromTheOrientations) {
  Trajectory truth;
  for (int i = 0; i < 20; ++i) truth.push_back({i * kFrame_ns, Pose(LookAlong(0.3), {0, 0, 0.1 * i})});
  Similarity turn;
  turn.rotation = RotZ(-1.1);
  const auto pairs = PairUp(truth, Moved(turn, truth));
  const AlignmentResult found = Align(pairs, Alignment::kYaw);
  EXPECT_LT(RotationAngle(found.X_WV.rotation, Eigen::Quaterniond(RotZ(1.1))), 1e-9);
  EXPECT_LT(Rmse(found, pairs), 1e-12);
}

}  // namespace
}  // namespace gaitcam
