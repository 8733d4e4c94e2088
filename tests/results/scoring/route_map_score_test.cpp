#include "results/scoring/route_map_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

Pose AtX(double x_m) { return {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}; }

/// Two sessions over the same two metres, a view every half metre; the second lies `off_m` too far to the left.
struct TwoSessions {
  RouteMap map;
  Trajectory truth;

  explicit TwoSessions(double off_m) {
    for (int session = 0; session < 2; ++session) {
      for (int i = 0; i < 5; ++i) {
        const int64_t stamp_ns = i * kSecond_ns + session * kSessionApart_ns;
        truth.push_back({stamp_ns, AtX(0.5 * i)});
        Pose stated = AtX(0.5 * i);
        stated.translation.y() = session * off_m;
        map.graph.nodes.push_back({stamp_ns, stated, {}});
        map.views.emplace_back();
      }
    }
    map.sessions = {0, 5};
  }
  void Join(int from, int to, double says_m, double trust = 1) {
    map.graph.links.push_back({from, to, AtX(says_m), Matrix6d::Identity(), true, trust, false});
  }
};

double ScoreOf(const RouteMapComparison& comparison, const std::string& name) {
  for (const Score& score : comparison.scores) {
    if (score.name == "route_" + name) return score.value;
  }
  ADD_FAILURE() << name;
  return 0;
}

TEST(RouteMapScore, SessionsThatLieApartAreAnErrorOfTheMap) {
  EXPECT_NEAR(ScoreOf(CompareRouteMap(TwoSessions(0).map, TwoSessions(0).truth), "error_rmse_m"), 0, 1e-9);
  const TwoSessions apart(0.2);
  // One alignment for both: each lies 0.1 m off.
  EXPECT_NEAR(ScoreOf(CompareRouteMap(apart.map, apart.truth), "error_rmse_m"), 0.1, 1e-9);
}

TEST(RouteMapScore, JoinsAreLinksBetweenSessionsAndJudgedByTheTruth) {
  TwoSessions both(0);
  both.Join(0, 2, 1);       // a loop within a session
  both.Join(0, 6, 0.5);     // right
  both.Join(1, 9, 1.8);     // wrong by 0.3 m
  both.Join(1, 8, 0.2, 0);  // wrong, and not trusted
  const RouteMapComparison comparison = CompareRouteMap(both.map, both.truth);
  EXPECT_EQ(ScoreOf(comparison, "sessions"), 2);
  EXPECT_EQ(ScoreOf(comparison, "views"), 10);
  EXPECT_EQ(ScoreOf(comparison, "joins"), 2);
  EXPECT_EQ(ScoreOf(comparison, "joins_false"), 1);
}

TEST(RouteMapScore, WithoutTruthNothingIsKnownOfErrors) {
  const RouteMapComparison comparison = CompareRouteMap(TwoSessions(0).map, {});
  EXPECT_TRUE(std::isnan(ScoreOf(comparison, "error_rmse_m")));
}

}  // namespace
}  // namespace gaitcam
