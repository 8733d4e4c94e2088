#include "algorithms/estimation/semi_consensus.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

Vector6d DrawTangent(RandomStream& random, double metres, double radians) {
  Vector6d tau;
  for (int i = 0; i < 6; ++i) tau[i] = random.Normal(0, i < 3 ? metres : radians);
  return tau;
}

/// Bends as a walk does, or more.
std::vector<Pose> DrawChain(int links, RandomStream& random) {
  std::vector<Pose> chain{ExpSe3(DrawTangent(random, 3, 1))};
  for (int k = 0; k < links; ++k) chain.push_back(Plus(chain.back(), DrawTangent(random, 0.3, 0.2)));
  return chain;
}

/// Of the motion that is left from the last pose to where the loop has it, in the world.
Vector6d Left(const std::vector<Pose>& chain, const Pose& closed) { return LogSe3(closed * chain.back().Inverse()); }

TEST(SemiConsensus, AllOfALoopIsClosedExactlyHoweverTheChainIsBent) {
  RandomStream random(1, "chains");
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<Pose> chain = DrawChain(1 + trial % 30, random);
    const Pose first = chain.front(), closed = Plus(chain.back(), DrawTangent(random, 0.5, 0.3));
    ReachSemiConsensus(chain, closed, 1);
    EXPECT_LT(Minus(chain.back(), closed).norm(), 1e-9);
    EXPECT_LT(Minus(chain.front(), first).norm(), 1e-15) << "the last one that was corrected stays";
  }
}

TEST(SemiConsensus, APartOfALoopClosesThatPart) {
  RandomStream random(2, "chains");
  for (const double alpha : {0.0, 0.1, 0.5, 0.8, 0.95}) {
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<Pose> chain = DrawChain(2 + trial, random);
      const Pose closed = Plus(chain.back(), DrawTangent(random, 0.5, 0.3));
      const Vector6d before = Left(chain, closed);
      ReachSemiConsensus(chain, closed, alpha);
      EXPECT_LT((Left(chain, closed) - (1 - alpha) * before).norm(), 1e-9) << alpha;
    }
  }
}

TEST(SemiConsensus, EveryRelativePoseTakesAnEqualShare) {
  RandomStream random(3, "chains");
  const std::vector<Pose> before = DrawChain(12, random);
  std::vector<Pose> after = before;
  ReachSemiConsensus(after, Plus(before.back(), DrawTangent(random, 0.5, 0.3)), 0.7);
  std::vector<Vector6d> shares;  // of each relative pose, as motions of the world
  for (size_t k = 1; k < before.size(); ++k) {
    const Pose R = before[k - 1].Inverse() * before[k], changed = after[k - 1].Inverse() * after[k];
    shares.push_back(Adjoint(before[k]) * Minus(changed, R));
  }
  for (const Vector6d& share : shares) EXPECT_LT((share - shares.front()).norm(), 1e-9);
}

TEST(SemiConsensus, AChainOfOnePoseHasNothingToGive) {
  std::vector<Pose> chain(1);
  ReachSemiConsensus(chain, ExpSe3(Vector6d::Constant(0.1)), 1);
  EXPECT_EQ(Minus(chain.front(), Pose()).norm(), 0);
}

TEST(MahalanobisMean, OfOneIsItselfAndOfEqualsTheMiddle) {
  RandomStream random(4, "mean");
  const Pose X = ExpSe3(DrawTangent(random, 2, 1));
  const Matrix6d one = Matrix6d::Identity();
  EXPECT_LT(Minus(MahalanobisMean({{X, one}}), X).norm(), 1e-12);
  Vector6d turn = DrawTangent(random, 0, 0.2);  // of turns alone, the middle of the shortest way is exactly the mean
  EXPECT_LT(Minus(MahalanobisMean({{X, one}, {Plus(X, turn), one}}), Plus(X, 0.5 * turn)).norm(), 1e-9);
}

TEST(MahalanobisMean, IsNearWhatIsKnownWell) {
  const Pose near = ExpSe3(Vector6d::Zero()), far = Pose(Eigen::Quaterniond::Identity(), {1, 0, 0});
  const Matrix6d one = Matrix6d::Identity();
  // Weights 4 and 1 of positions along one axis: a fifth of the way.
  const Pose mean = MahalanobisMean({{near, 0.25 * one}, {far, one}});
  EXPECT_NEAR(mean.translation.x(), 0.2, 1e-9);
  EXPECT_LT(mean.translation.tail<2>().norm(), 1e-9);
}

TEST(MahalanobisMean, IsAMinimum) {
  RandomStream random(5, "mean");
  std::vector<LikelyPose> poses;
  for (int i = 0; i < 3; ++i) {
    const Vector6d sigma = (Vector6d() << 0.1, 0.2, 0.3, 0.05, 0.1, 0.2).finished() * (1 + i);
    poses.push_back({ExpSe3(DrawTangent(random, 0.3, 0.2)), sigma.cwiseAbs2().asDiagonal()});
  }
  const auto cost = [&](const Pose& X) {
    double sum = 0;
    for (const LikelyPose& pose : poses) {
      const Vector6d e = Minus(X, pose.X);
      sum += e.dot(pose.covariance.inverse() * e);
    }
    return sum;
  };
  const Pose mean = MahalanobisMean(poses);
  for (int axis = 0; axis < 6; ++axis) {
    for (const double step : {-1e-3, 1e-3}) EXPECT_GT(cost(Plus(mean, step * Vector6d::Unit(axis))), cost(mean));
  }
}

}  // namespace
}  // namespace gaitcam
