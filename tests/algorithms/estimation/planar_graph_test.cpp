#include "algorithms/estimation/planar_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// Once round a circle of 20 poses, the last where the first is.
std::vector<PlanarPose> Circle() {
  std::vector<PlanarPose> poses{{}};
  const PlanarPose step{{0.3, 0.02}, 2 * std::numbers::pi / 20};
  for (int i = 0; i < 20; ++i) poses.push_back(poses.back() * step);
  return poses;
}

std::vector<PlanarEdge> Motions(const std::vector<PlanarPose>& poses, double sigma, uint64_t seed) {
  RandomStream random(seed, "motions");
  std::vector<PlanarEdge> edges;
  for (int i = 1; i < int(poses.size()); ++i) {
    const PlanarPose true_motion = poses[size_t(i - 1)].Inverse() * poses[size_t(i)];
    const double nx = random.Normal(0, sigma), ny = random.Normal(0, sigma), nyaw = random.Normal(0, sigma);
    edges.push_back({i - 1, i, true_motion * PlanarPose{{nx, ny}, nyaw}, sigma * sigma * Eigen::Matrix3d::Identity()});
  }
  return edges;
}

std::vector<PlanarPose> Chain(const std::vector<PlanarEdge>& edges) {
  std::vector<PlanarPose> poses{{}};
  for (const PlanarEdge& edge : edges) poses.push_back(poses.back() * edge.motion);
  return poses;
}

double Worst_m(const std::vector<PlanarPose>& a, const std::vector<PlanarPose>& b) {
  double worst = 0;
  for (size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i].position - b[i].position).norm());
  return worst;
}

TEST(PlanarGraph, WithoutLoopsTheChainOfMotionsIsTheAnswer) {
  const std::vector<PlanarEdge> edges = Motions(Circle(), 0.01, 1);
  std::vector<PlanarPose> start = Circle();  // anywhere
  EXPECT_LT(Worst_m(SolvePlanarGraph(start, edges), Chain(edges)), 1e-6);
}

TEST(PlanarGraph, AnExactLoopClosesTheChainAndTakesMostOfItsErrorAway) {
  double before = 0, after = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    std::vector<PlanarEdge> edges = Motions(Circle(), 0.01, seed);
    const std::vector<PlanarPose> chain = Chain(edges);
    edges.push_back({0, 20, {}, 1e-10 * Eigen::Matrix3d::Identity(), true});  // once round: yaw is 2 pi, not 0
    const std::vector<PlanarPose> solved = SolvePlanarGraph(chain, edges);
    EXPECT_LT(solved.back().position.norm(), 1e-3);
    EXPECT_NEAR(solved.back().heading, 2 * std::numbers::pi, 1e-3);
    before += Worst_m(chain, Circle());
    after += Worst_m(solved, Circle());
  }
  EXPECT_LT(after, 0.6 * before);  // a bridge between two fixed ends: half the spread of a free walk, in its middle
}

TEST(PlanarGraph, APlaceTakenForAnotherDoesLittleHarm) {
  std::vector<PlanarEdge> edges = Motions(Circle(), 0.001, 2);
  edges.push_back({0, 20, {}, 1e-4 * Eigen::Matrix3d::Identity(), true});
  edges.push_back({0, 10, {}, 1e-4 * Eigen::Matrix3d::Identity(), true});  // 1.9 m off
  EXPECT_LT(Worst_m(SolvePlanarGraph(Circle(), edges), Circle()), 0.02);
}

TEST(PlanarGraphCovariances, AddUpAlongAChainAndShrinkWithALoop) {
  const Eigen::Matrix3d step = Eigen::Vector3d(0.01, 0.02, 0.001).cwiseAbs2().asDiagonal();
  std::vector<PlanarPose> poses = {{}};
  std::vector<PlanarEdge> edges;
  for (int i = 0; i < 4; ++i) {
    const PlanarPose motion({1, 0.1 * i}, 0.5);
    poses.push_back(poses.back() * motion);
    edges.push_back({i, i + 1, motion, step, false});
  }
  const std::vector<Eigen::Matrix3d> chain = PlanarGraphCovariances(poses, edges);
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((chain[size_t(i)] - expected).norm(), 1e-12) << i;
    const Eigen::Matrix3d J = PlanarAdjoint(edges[size_t(i)].motion.Inverse());
    expected = J * expected * J.transpose() + step;
  }
  edges.push_back({0, 4, poses[4], step, true});
  const std::vector<Eigen::Matrix3d> loop = PlanarGraphCovariances(poses, edges);
  EXPECT_LT(loop[4].trace(), step.trace());
  EXPECT_LT(loop[2].trace(), chain[2].trace());
}

}  // namespace
}  // namespace gaitcam
