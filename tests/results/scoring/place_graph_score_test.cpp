#include "results/scoring/place_graph_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

/// Along corners at 0.1 m/s, 10 poses per second; the head's pan moves the camera to and fro by 2 cm.
Trajectory Along(const std::vector<Eigen::Vector2d>& corners) {
  Trajectory truth;
  int64_t stamp = 0;
  for (size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i + 1] - corners[i];
    const int steps = int(std::lround(leg.norm() / 0.01));
    for (int k = 0; k < steps; ++k, stamp += kSecond / 10) {
      const Eigen::Vector2d p = corners[i] + leg * (double(k) / steps);
      truth.push_back({stamp, Pose{Eigen::Quaterniond::Identity(), {p.x(), p.y() + 0.02 * std::sin(0.3 * k), 0.3}}});
    }
  }
  return truth;
}

double Value(const PlaceGraphComparison& comparison, const std::string& name) {
  for (const Score& score : comparison.scores) {
    if (score.name == name) return score.value;
  }
  ADD_FAILURE() << name;
  return NAN;
}

/// A figure of eight on its side: out, round and through the first leg again, at (2, 0) after 8 m.
const std::vector<Eigen::Vector2d> kEight = {{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, -2}};

PlaceGraph Nodes(std::initializer_list<double> seconds) {
  PlaceGraph graph;
  for (const double s : seconds) graph.nodes.push_back({int64_t(s * 1e9), 169, {}});
  return graph;
}

TEST(PlaceGraphScore, ALoopClosedAtTheCrossingIsRightAndFound) {
  PlaceGraph graph = Nodes({0, 20, 40, 60});  // at x = 0, 2, 4 and at (4, 2)
  graph.links.push_back({3, 1, true, 100 * kSecond});
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, Along(kEight));
  ASSERT_EQ(comparison.crossings.size(), 1U);
  EXPECT_NEAR(comparison.crossings[0].at_m.x(), 2, 0.05);
  EXPECT_NEAR(comparison.crossings[0].at_m.y(), 0, 0.05);
  EXPECT_NEAR(comparison.crossings[0].return_m, 10, 0.5);  // the camera's to and fro makes it a little longer
  EXPECT_EQ(Value(comparison, "loop_crossings_found"), 1);
  EXPECT_EQ(Value(comparison, "loops_false"), 0);
  EXPECT_EQ(Value(comparison, "loop_precision"), 1);
  EXPECT_EQ(Value(comparison, "loop_returns"), 1);
  EXPECT_EQ(Value(comparison, "loop_recall"), 1);
  EXPECT_EQ(Value(comparison, "place_node_bytes"), 169);
  EXPECT_LT(comparison.loops[0].distance_m, 0.1);
}

TEST(PlaceGraphScore, AFilmOfFewFramesIsScoredAsOneOfMany) {
  PlaceGraph graph = Nodes({0, 20, 40, 60});
  graph.links.push_back({3, 1, true, 100 * kSecond});
  const Trajectory all = Along(kEight);
  Trajectory few;
  for (size_t i = 0; i < all.size(); i += 100) few.push_back(all[i]);  // a metre from one to the next
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, few);
  ASSERT_EQ(comparison.crossings.size(), 1U);
  EXPECT_NEAR(comparison.crossings[0].return_m, 10, 0.2);
  EXPECT_EQ(Value(comparison, "loop_returns"), 1);
  EXPECT_EQ(Value(comparison, "loop_recall"), 1);
}

TEST(PlaceGraphScore, ALoopToAPlaceFarAwayIsFalseAndFindsNothing) {
  PlaceGraph graph = Nodes({0, 20, 40, 60});
  graph.links.push_back({3, 0, true, 100 * kSecond});
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, Along(kEight));
  EXPECT_EQ(Value(comparison, "loops_false"), 1);
  EXPECT_EQ(Value(comparison, "loop_precision"), 0);
  EXPECT_EQ(Value(comparison, "loop_crossings_found"), 0);
  EXPECT_EQ(Value(comparison, "loop_recall"), 0);
  EXPECT_NEAR(comparison.loops[0].distance_m, 2, 0.1);
}

TEST(PlaceGraphScore, OneLoopIsWorthOneCrossing) {
  // Two crossings 0.8 m apart, at (1.8, 0) and at (1, 0); one loop between them.
  PlaceGraph graph = Nodes({0, 14, 30});
  const Trajectory truth = Along({{0, 0}, {3, 0}, {3, 1}, {1.8, 1}, {1.8, -0.4}, {1, -0.4}, {1, 1}});
  graph.links.push_back({2, 1, true, 62 * kSecond});  // at (1.8, 0.0)
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, truth);
  EXPECT_EQ(Value(comparison, "loop_crossings"), 2);
  EXPECT_EQ(Value(comparison, "loops_false"), 0);
  EXPECT_EQ(Value(comparison, "loop_crossings_found"), 1);
}

TEST(PlaceGraphScore, LinksOfTheWayAreNoLoopsAndAStraightWayAsksForNone) {
  PlaceGraph graph = Nodes({0, 20});
  graph.links.push_back({0, 1, false, 20 * kSecond});
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, Along({{0, 0}, {4, 0}}));
  EXPECT_EQ(Value(comparison, "loops_closed"), 0);
  EXPECT_EQ(Value(comparison, "loop_crossings"), 0);
  EXPECT_EQ(Value(comparison, "loop_returns"), 0);
  EXPECT_TRUE(std::isnan(Value(comparison, "loop_recall")));
  EXPECT_TRUE(std::isnan(Value(comparison, "loop_precision")));
}

TEST(PlaceGraphScore, AnEmptyMapIsScoredAndNoTruthIsTooLittle) {
  EXPECT_EQ(Value(ComparePlaceGraph({}, Along(kEight)), "place_nodes"), 0);
  EXPECT_THROW(ComparePlaceGraph({}, {}), TooLittleData);
}

}  // namespace
}  // namespace gaitcam
