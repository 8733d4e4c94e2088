#include "results/scoring/pose_graph_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

double Value(const PoseGraphComparison& comparison, const std::string& name) {
  for (const Score& score : comparison.scores) {
    if (score.name == name) return score.value;
  }
  ADD_FAILURE() << name;
  return 0;
}

/// Ten poses, 0.1 m apart, once a second.
Trajectory Walk() {
  Trajectory truth;
  for (int i = 0; i < 10; ++i)
    truth.push_back({int64_t(i) * 1'000'000'000, {Eigen::Quaterniond(1, 0, 0, 0), {0.1 * i, 0, 0}}});
  return truth;
}

GraphLink Loop(int from, int to, double x_m, double turn_rad, double trust) {
  return {from, to, Pose(RotZ(turn_rad), {x_m, 0, 0}), Matrix6d::Identity(), true, trust};
}

TEST(PoseGraphScore, LoopsAreJudgedByTheMotionThatTheySay) {
  PoseGraph graph;
  graph.candidates = 40;
  for (const StampedPose& pose : Walk()) graph.nodes.push_back({pose.stamp_ns, {}, {}});  // poses do not matter
  graph.links.push_back({0, 1, {}, Matrix6d::Identity(), false, 1});                      // no loop
  graph.links.push_back(Loop(0, 5, 0.55, 0.05, 1));  // off by 5 cm and 3 deg: right
  graph.links.push_back(Loop(0, 5, 0.65, 0, 1));     // off by 15 cm
  graph.links.push_back(Loop(0, 5, 0.5, 0.1, 0));    // off by 6 deg, and refused
  graph.links.push_back(Loop(2, 9, 0.7, 0, 0));      // right, and refused
  const PoseGraphComparison comparison = ComparePoseGraph(graph, Walk());
  EXPECT_EQ(Value(comparison, "graph_nodes"), 10);
  EXPECT_EQ(Value(comparison, "graph_nodes_ratio"), 0.25);
  EXPECT_EQ(Value(comparison, "graph_loops"), 2);
  EXPECT_EQ(Value(comparison, "graph_loops_false"), 1);
  EXPECT_EQ(Value(comparison, "graph_loops_refused"), 1);
  EXPECT_EQ(Value(comparison, "graph_loops_lost"), 1);
  EXPECT_NEAR(comparison.loops[0].error_m, 0.05, 1e-12);
}

TEST(PoseGraphScore, LinksAlongTheWayAreSeenOrReckoned) {
  PoseGraph graph;
  for (const StampedPose& pose : Walk()) graph.nodes.push_back({pose.stamp_ns, {}, {}});
  for (int to = 1; to < 5; ++to) graph.links.push_back({to - 1, to, {}, Matrix6d::Identity(), false, 1, to == 2});
  graph.links.push_back(Loop(0, 4, 0.4, 0, 1));                              // counts as neither,
  graph.links.push_back({0, 2, {}, Matrix6d::Identity(), false, 1, false});  // nor does a second link to a node
  EXPECT_EQ(Value(ComparePoseGraph(graph, Walk()), "graph_links_seen_ratio"), 0.75);
  EXPECT_TRUE(std::isnan(Value(ComparePoseGraph({}, Walk()), "graph_links_seen_ratio")));
}

TEST(PoseGraphScore, WhereThereIsNoTruthALoopIsNotJudged) {
  PoseGraph graph;
  graph.nodes = {{0, {}, {}}, {99'000'000'000, {}, {}}};
  graph.links.push_back(Loop(0, 1, 0, 0, 1));
  const PoseGraphComparison comparison = ComparePoseGraph(graph, Walk());
  EXPECT_TRUE(std::isnan(comparison.loops[0].error_m));
  EXPECT_EQ(Value(comparison, "graph_loops"), 0);
  EXPECT_TRUE(std::isnan(Value(comparison, "graph_nodes_ratio"))) << "no keyframes are known";
}

}  // namespace
}  // namespace gaitcam
