#include "algorithms/estimation/pose_graph_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

constexpr double kSigma_m = 0.01, kSigma_rad = 0.005;

Matrix6d StepCovariance(double scale = 1) {
  Vector6d sigma;
  sigma << kSigma_m, 0.5 * kSigma_m, kSigma_m, kSigma_rad, 2 * kSigma_rad, kSigma_rad;
  return (scale * sigma).cwiseAbs2().asDiagonal();
}

Vector6d Draw(const Matrix6d& covariance, RandomStream& random) {
  Vector6d unit;
  for (int i = 0; i < 6; ++i) unit[i] = random.Normal();
  return covariance.llt().matrixL() * unit;
}

/// Twice round a circle of 20 poses, swaying: the second round comes by the poses of the first.
std::vector<Pose> Rounds() {
  std::vector<Pose> poses{{}};
  for (int i = 0; i < 40; ++i) {
    Vector6d step;
    step << 0.3, 0.02, 0.01 * std::sin(0.5 * i), 0.02 * std::cos(0.5 * i), 0, 2 * std::numbers::pi / 20;
    poses.push_back(Plus(poses.back(), step));
  }
  return poses;
}

GraphLink Measured(const std::vector<Pose>& truth, int from, int to, const Matrix6d& covariance, bool loop,
                   RandomStream& random) {
  const Pose X_FT = truth[size_t(from)].Inverse() * truth[size_t(to)];
  return {from, to, Plus(X_FT, Draw(covariance, random)), covariance, loop, 1};
}

/// Steps with noise, the chain of them, and a loop at every second pose of the second round.
/// @param false_every of the loops one in so many leads to a pose that it is not at; 0: none.
PoseGraph NoisyGraph(const std::vector<Pose>& truth, bool loops, int false_every, uint64_t seed) {
  RandomStream random(seed, "noisy_graph");
  PoseGraph graph;
  graph.nodes.push_back({0, truth[0], {}});
  for (int i = 1; i < int(truth.size()); ++i) {
    graph.links.push_back(Measured(truth, i - 1, i, StepCovariance(), false, random));
    graph.nodes.push_back({i, graph.nodes.back().X_WC * graph.links.back().X_FT, {}});
  }
  for (int i = 21, loop = 1; loops && i < int(truth.size()); i += 2, ++loop) {
    graph.links.push_back(Measured(truth, i - 20, i, StepCovariance(0.5), true, random));
    if (false_every > 0 && loop % false_every == 0) {
      // What it saw looks like the pose a third of a round further on.
      graph.links.back().from = (i - 20 + 7) % 20;
    }
  }
  return graph;
}

double Worst_m(const PoseGraph& graph, const std::vector<Pose>& truth) {
  double worst = 0;
  for (size_t i = 0; i < truth.size(); ++i)
    worst = std::max(worst, (graph.nodes[i].X_WC.translation - truth[i].translation).norm());
  return worst;
}

TEST(PoseGraphSolver, WithoutLoopsTheChainOfMotionsIsTheAnswer) {
  PoseGraph graph = NoisyGraph(Rounds(), false, 0, 1);
  const PoseGraph chain = graph;
  for (GraphNode& node : graph.nodes) node.X_WC = Rounds()[size_t(node.stamp_ns)];  // from elsewhere
  EXPECT_LT(SolvePoseGraph(graph), 1e-12);
  for (size_t i = 0; i < chain.nodes.size(); ++i)
    EXPECT_LT(Minus(graph.nodes[i].X_WC, chain.nodes[i].X_WC).norm(), 1e-7);
}

TEST(PoseGraphSolver, TheFirstPoseIsHeld) {
  PoseGraph graph = NoisyGraph(Rounds(), true, 0, 1);
  const Pose first = graph.nodes[0].X_WC;
  SolvePoseGraph(graph);
  EXPECT_EQ(Minus(graph.nodes[0].X_WC, first).norm(), 0);
}

TEST(PoseGraphSolver, LoopsTakeMostOfTheDriftAway) {
  double before = 0, after = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    PoseGraph graph = NoisyGraph(Rounds(), true, 0, seed);
    before += Worst_m(graph, Rounds());
    SolvePoseGraph(graph);
    after += Worst_m(graph, Rounds());
  }
  // The drift of 40 steps becomes that of a round, which is walked twice: about a half of a half.
  EXPECT_LT(after, 0.5 * before);
}

/// chi-square with 600 degrees of freedom has a standard deviation of 34.6; 4 of them about 600.
TEST(PoseGraphSolver, CovariancesAreThoseOfItsErrors) {
  const std::vector<Pose> truth = Rounds();
  constexpr int kRuns = 100;
  double last = 0, between = 0;
  for (uint64_t seed = 1; seed <= kRuns; ++seed) {
    PoseGraph graph = NoisyGraph(truth, true, 0, 100 + seed);
    SolvePoseGraph(graph);
    const PoseGraphCovariances covariances(graph);
    const Vector6d e = Minus(truth.back(), graph.nodes.back().X_WC);
    last += e.dot(covariances.Of(40).llt().solve(e));
    const Pose X_FT = graph.nodes[10].X_WC.Inverse() * graph.nodes[33].X_WC;
    const Vector6d e_FT = Minus(truth[10].Inverse() * truth[33], X_FT);
    between += e_FT.dot(covariances.Between(10, 33).llt().solve(e_FT));
  }
  EXPECT_NEAR(last, 6 * kRuns, 4 * 34.6);
  EXPECT_NEAR(between, 6 * kRuns, 4 * 34.6);
}

TEST(PoseGraphSolver, CovarianceOfAChainIsThatOfTheProduct) {
  PoseGraph graph = NoisyGraph(Rounds(), false, 0, 3);
  const PoseGraphCovariances covariances(graph);
  Matrix6d chain = Matrix6d::Zero();
  for (const GraphLink& link : graph.links) chain = CovarianceOfProduct(link.X_FT, chain, link.covariance);
  EXPECT_LT((covariances.Of(40) - chain).norm(), 1e-9 * chain.norm());
  EXPECT_EQ(covariances.Of(0).norm(), 0);
  EXPECT_LT((covariances.Between(39, 40) - StepCovariance()).norm(), 1e-9 * StepCovariance().norm());
}

/// The motions of one sensor that stretches and turns all of them alike.
std::vector<CommonErrors> OneSensors(const PoseGraph& graph) {
  std::vector<CommonErrors> errors;
  for (const GraphLink& link : graph.links) {
    errors.push_back(CommonErrors::Zero(6, 2));
    errors.back().col(0).head<3>() = 0.01 * link.X_FT.translation;
    errors.back()(5, 1) = 0.003 * link.X_FT.translation.norm();
  }
  return errors;
}

TEST(PoseGraphSolver, ErrorsInCommonMoveTheNodesAsASolutionWithThemDoes) {
  PoseGraph graph = NoisyGraph(Rounds(), true, 0, 5);
  SolvePoseGraph(graph);
  const std::vector<CommonErrors> of_links = OneSensors(graph);
  const std::vector<CommonErrors> of_nodes = PoseGraphCovariances(graph).InCommon(of_links, 2);
  for (int error = 0; error < 2; ++error) {
    PoseGraph moved = graph;
    for (size_t l = 0; l < moved.links.size(); ++l)
      moved.links[l].X_FT = Plus(graph.links[l].X_FT, of_links[l].col(error));
    SolvePoseGraph(moved);
    EXPECT_EQ(of_nodes[0].norm(), 0);
    double most = 0, off = 0;
    for (size_t n = 1; n < graph.nodes.size(); ++n) {
      const Vector6d found = Minus(moved.nodes[n].X_WC, graph.nodes[n].X_WC);
      most = std::max(most, found.norm());
      off = std::max(off, (found - of_nodes[n].col(error)).norm());
    }
    EXPECT_LT(off, 0.01 * most) << "of first order, in motions that are off by a hundredth";
  }
}

TEST(PoseGraphSolver, ErrorsInCommonOfAChainAreCarriedOnAndAdded) {
  const PoseGraph graph = NoisyGraph(Rounds(), false, 0, 3);
  const std::vector<CommonErrors> of_links = OneSensors(graph);
  CommonErrors chain = CommonErrors::Zero(6, 2);
  for (size_t l = 0; l < of_links.size(); ++l) chain = Adjoint(graph.links[l].X_FT.Inverse()) * chain + of_links[l];
  const CommonErrors last = PoseGraphCovariances(graph).InCommon(of_links, 2).back();
  EXPECT_LT((last - chain).norm(), 1e-9 * chain.norm());
}

/// Of 10 loops, 2 false ones that agree with nothing (20 %) or 5 (50 %).
TEST(PoseGraphSolver, FalseLoopsAreFoundAndTrueOnesKept) {
  for (const int false_every : {5, 2}) {
    int kept_false = 0, lost_true = 0;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      PoseGraph graph = NoisyGraph(Rounds(), true, false_every, seed);
      SolvePoseGraph(graph);
      for (const GraphLink& link : graph.links) {
        if (!link.loop) continue;
        EXPECT_TRUE(link.trust == 0 || link.trust == 1);
        const bool is_true = link.to - link.from == 20;
        kept_false += !is_true && link.trust == 1;
        lost_true += is_true && link.trust == 0;
      }
    }
    EXPECT_EQ(kept_false, 0) << "one in " << false_every;
    // By the threshold, one true loop in a thousand.
    EXPECT_LE(lost_true, 1) << "one in " << false_every;
  }
}

TEST(PoseGraphSolver, ALoopAfterALargeDriftIsNotMistakenForAFalseOne) {
  PoseGraph graph = NoisyGraph(Rounds(), true, 0, 4);
  for (GraphLink& link : graph.links) {
    if (link.loop) link.covariance = StepCovariance(0.01);  // far more exact than 20 steps' drift, and exact
    if (link.loop) link.X_FT = Rounds()[size_t(link.from)].Inverse() * Rounds()[size_t(link.to)];
  }
  SolvePoseGraph(graph);
  for (const GraphLink& link : graph.links) EXPECT_EQ(link.trust, 1);
}

TEST(InformationGain, IsThatOfOneDimensionTimesSixAndNothingForWhatIsKnown) {
  const Matrix6d I = Matrix6d::Identity();
  EXPECT_NEAR(InformationGain(3 * I, I), 6 * 0.5 * std::log(4.0), 1e-12);
  EXPECT_NEAR(InformationGain(1e-9 * I, I), 0, 1e-8);
}

TEST(InnovationChi2, IsTheSquaredDistanceInStandardDeviations) {
  Vector6d off = Vector6d::Zero();
  off[0] = 0.3;
  const Pose expected = Plus({}, Vector6d::Constant(0.2));
  const Matrix6d covariance = 0.005 * Matrix6d::Identity();
  EXPECT_NEAR(InnovationChi2(expected, covariance, Plus(expected, off), covariance), 9, 1e-9);
  EXPECT_TRUE(std::isinf(InnovationChi2(expected, -covariance, expected, Matrix6d::Zero())));
}

}  // namespace
}  // namespace gaitcam
