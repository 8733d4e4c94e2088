#include "algorithms/features/match_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace gaitcam {
namespace {

constexpr int kStill = 80, kMoved = 40;

/// Two views with a match for each key point: those of a still scene by a pan and a zoom, then those on somebody who
/// walks 110 px on: less is within the threshold of what is far from it.
struct FilteredViews {
  Features a, b;
  std::vector<Match> matches;

  FilteredViews() {
    RandomStream random(5, "filtered_views");
    for (int i = 0; i < kStill + kMoved; ++i) {
      const bool still = i < kStill;
      const Eigen::Vector2d p = still ? Eigen::Vector2d(random.Uniform(0, 480), random.Uniform(0, 320))
                                      : Eigen::Vector2d(random.Uniform(200, 260), random.Uniform(80, 240));
      const Eigen::Vector2d q =
          still ? Eigen::Vector2d(1.02 * p + Eigen::Vector2d(8, -3)) : p + Eigen::Vector2d(110, 8);
      a.keypoints.emplace_back(float(p.x()), float(p.y()), 5.f);
      b.keypoints.emplace_back(float(q.x()), float(q.y()), 5.f);
      matches.push_back({i, i, 0});
    }
  }
  std::vector<Match> Filtered(const MatchFilterOptions& options, uint64_t seed = 1) const {
    RandomStream random(seed, "filter");
    return FilterMatches(matches, a, b, options, random);
  }
};

MatchFilterOptions FilterOf(MatchFilterKind kind) {
  MatchFilterOptions options;
  options.filter = kind;
  return options;
}

int CountMoved(const std::vector<Match>& matches) {
  return int(std::count_if(matches.begin(), matches.end(), [](const Match& match) { return match.a >= kStill; }));
}

TEST(MatchFilter, NoneKeepsAllAndDrawsNothing) {
  const FilteredViews views;
  RandomStream random(1, "filter"), untouched(1, "filter");
  EXPECT_EQ(FilterMatches(views.matches, views.a, views.b, {}, random).size(), views.matches.size());
  EXPECT_EQ(random.Bits(), untouched.Bits());
}

TEST(MatchFilter, TheConsensusKeepsWhatStandsStill) {
  const std::vector<Match> kept = FilteredViews().Filtered(FilterOf(MatchFilterKind::kConsensus));
  EXPECT_EQ(CountMoved(kept), 0);
  EXPECT_GE(int(kept.size()), kStill * 9 / 10) << "those at the rim have few neighbours";
}

TEST(MatchFilter, IcgmIsAlgorithm1OverTheKeyPoints) {
  const FilteredViews views;
  RandomStream random(1, "filter");
  const std::vector<int> expected =
      FilterByGravity(PositionsOf(views.matches, views.a, views.b), IcgmOptions(), random).kept;
  std::vector<int> kept;
  for (const Match& match : views.Filtered(FilterOf(MatchFilterKind::kIcgm))) kept.push_back(match.a);
  EXPECT_EQ(kept, expected);
  EXPECT_LT(kept.size(), views.matches.size());
}

TEST(MatchFilter, TheThresholdIsTheFiltersOwnUnlessGiven) {
  MatchFilterOptions options = FilterOf(MatchFilterKind::kIcgm);
  EXPECT_EQ(options.Icgm().threshold, 0.08);
  EXPECT_EQ(FilterOf(MatchFilterKind::kConsensus).Icgm().threshold, 0.12);
  options.icgm_threshold = 1;
  EXPECT_EQ(FilteredViews().Filtered(options).size(), size_t(kStill + kMoved)) << "at most 1 by definition";
  options.icgm_threshold = 0.2;
  options.icgm_automatic = true;
  EXPECT_TRUE(options.Icgm().automatic);
  EXPECT_EQ(options.Icgm().threshold, 0.2);
}

TEST(MatchFilter, OfFewerThanTwoMatchesNoneIsBorneOut) {
  FilteredViews views;
  for (const MatchFilterKind kind : {MatchFilterKind::kIcgm, MatchFilterKind::kConsensus}) {
    views.matches.resize(1);
    EXPECT_TRUE(views.Filtered(FilterOf(kind)).empty());
    views.matches.clear();
    EXPECT_TRUE(views.Filtered(FilterOf(kind)).empty());
    views = FilteredViews();
  }
}

}  // namespace
}  // namespace gaitcam
