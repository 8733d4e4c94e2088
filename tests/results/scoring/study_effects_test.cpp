// What a study concludes from its runs: checked against made-up ones whose effects are known.

#include "results/scoring/study_effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/results/study_table_made_up.h"

namespace gaitcam {
namespace {

const StudyEffect& Find(const std::vector<StudyEffect>& effects, size_t axis, size_t level, const std::string& metric,
                        std::optional<std::pair<size_t, size_t>> within = std::nullopt) {
  return *std::find_if(effects.begin(), effects.end(), [&](const StudyEffect& e) {
    return e.axis == axis && e.level == level && e.metric.name == metric && e.within == within;
  });
}

TEST(StudyEffects, AKnownShiftIsFoundWithItsSizeAndDirection) {
  const MadeUpStudy study(16);
  const StudyEffect& effect = Find(study.effects, 0, 3, "ate_sim3_rmse_m", std::pair<size_t, size_t>(2, 1));
  EXPECT_EQ(effect.pairs, 48u);  // three gaits, sixteen seeds
  EXPECT_EQ(effect.walks, 16u);
  EXPECT_EQ(effect.unpaired, 0u);
  EXPECT_LT(effect.p_holm, 0.01);
  EXPECT_EQ(effect.Verdict(0.95), -1);
  EXPECT_GT(effect.shift, 0);
  EXPECT_LT(effect.ends.low, effect.shift);
  EXPECT_GT(effect.ends.high, effect.shift);
  EXPECT_GT(effect.ends.low, 0);
  EXPECT_EQ(EffectText(study.table, effect), "exposure_ms=33 vs 0, system=mobif_vo_plus");
}

// Against the definition, all pairs listed; with ties, and with zeros on which bisection alone would never land.
TEST(StudyEffects, TheShiftIsTheHodgesLehmannEstimateToTheBit) {
  StudyTable table;
  table.axes = {{"system", {"a", "b"}, 0}};
  table.metrics = {{"ate_rmse_m", 0, "m", "", Better::kLower}};
  RandomStream random(9, "shift");
  for (const size_t n : {1u, 2u, 7u, 8u, 40u}) {
    std::vector<double> differences;
    table.runs.clear();
    table.seeds = n;
    for (size_t level = 0; level < 2; ++level) {
      for (uint64_t seed = 1; seed <= n; ++seed) {
        StudyRun run;
        run.levels = {level};
        run.seed = seed;
        run.scores["ate_rmse_m"] = level == 0 ? 0 : std::round(4 * random.Normal()) / 4;
        if (level == 1) differences.push_back(run.scores["ate_rmse_m"]);
        table.runs.push_back(run);
      }
    }
    EXPECT_EQ(RankEffects(table, {}, std::nullopt)[0].shift, HodgesLehmann(differences)) << n;
  }
}

TEST(StudyEffects, WhatMakesNoDifferenceIsNotSure) {
  const MadeUpStudy study;
  for (const StudyEffect& effect : study.effects) {
    if (effect.metric.name != "rotation_gain") continue;
    EXPECT_GT(effect.p_holm, 0.05) << EffectText(study.table, effect);
  }
}

// The reference is the level that the axis names, not its first.
TEST(StudyEffects, DifferencesAreFromTheReferenceLevel) {
  const MadeUpStudy study;
  EXPECT_GT(Find(study.effects, 1, 2, "ate_sim3_rmse_m").shift, 0);  // brisk is worse than normal
  EXPECT_LT(Find(study.effects, 1, 0, "ate_sim3_rmse_m").shift, 0);  // slow is better
  EXPECT_EQ(std::count_if(study.effects.begin(), study.effects.end(),
                          [](const StudyEffect& e) { return e.axis == 1 && e.level == 1; }),
            0);
}

TEST(StudyEffects, PairsInWhichOneRunWasNotScoredAreCountedNotGuessed) {
  const MadeUpStudy study;
  const StudyEffect& effect = Find(study.effects, 0, 3, "ate_sim3_rmse_m", std::pair<size_t, size_t>(2, 0));
  EXPECT_EQ(effect.pairs, 15u);
  EXPECT_EQ(effect.unpaired, 3u);  // odd seeds of the brisk walk
  EXPECT_EQ(effect.walks, 6u);     // the other gaits' pairs are there of each seed
}

TEST(StudyEffects, PairingBySeedFindsAShiftThatIsSmallAgainstTheSpreadOverSeeds) {
  StudyTable table;
  table.axes = {{"system", {"a", "b"}, 0}};
  table.metrics = {{"ate_rmse_m", 0, "m", "", Better::kLower}};
  table.seeds = 10;
  for (size_t level = 0; level < 2; ++level) {
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      StudyRun run;
      run.levels = {level};
      run.seed = seed;
      run.scores["ate_rmse_m"] = double(seed) + 0.01 * double(level) * (1 + 0.1 * double(seed));
      table.runs.push_back(run);
    }
  }
  const std::vector<StudyEffect> effects = RankEffects(table, {}, std::nullopt);
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_NEAR(effects[0].p, 2.0 / 1024, 1e-12);  // all ten differences of one sign: 2 * 2^-10
  EXPECT_NEAR(effects[0].shift, 0.01 * 1.55, 1e-9);
}

/// Ten other levels that all see the same walk: what differs by chance is the seed's, not the run's.
StudyTable SharedWalks(size_t seeds, RandomStream& random) {
  StudyTable table;
  table.axes = {{"system", {"a", "b"}, 0}, {"camera.exposure_ms", std::vector<std::string>(10, "0"), 0}};
  table.metrics = {{"ate_rmse_m", 0, "m", "", Better::kLower}};
  table.seeds = seeds;
  std::vector<double> of_seed;
  for (size_t i = 0; i < 2 * seeds; ++i) of_seed.push_back(random.Normal());
  for (size_t system = 0; system < 2; ++system) {
    for (size_t exposure = 0; exposure < 10; ++exposure) {
      for (uint64_t seed = 0; seed < seeds; ++seed) {
        StudyRun run;
        run.levels = {system, exposure};
        run.seed = seed;
        run.scores["ate_rmse_m"] = 3 + of_seed[2 * seed + system] + 0.1 * random.Normal();
        table.runs.push_back(run);
      }
    }
  }
  return table;
}

// Two systems of the same accuracy: where the runs of a walk counted one by one, half of all studies would be "sure".
TEST(StudyEffects, RunsThatShareAWalkCountOnce) {
  RandomStream random(4, "clusters");
  constexpr int kStudies = 400;
  int sure = 0, held = 0;
  for (int i = 0; i < kStudies; ++i) {
    const std::vector<StudyEffect> effects = RankEffects(SharedWalks(12, random), {}, std::nullopt);
    const StudyEffect& systems = Find(effects, 0, 1, "ate_rmse_m");
    ASSERT_EQ(systems.pairs, 120u);
    ASSERT_EQ(systems.walks, 12u);
    sure += systems.p < 0.05;
    held += systems.ends.low <= 0 && 0 <= systems.ends.high;
  }
  EXPECT_LT(sure, 0.05 * kStudies + 13);  // 5 % of 400, and three standard errors
  EXPECT_GT(held, 0.95 * kStudies - 13);
}

TEST(StudyEffects, HolmCorrectsForEveryComparisonAndRanksTheSurestFirst) {
  const MadeUpStudy study;
  // 3 exposures, each overall and within two systems; 2 gaits likewise; 1 system: 16 comparisons of 3 scores.
  EXPECT_EQ(study.effects.size(), 48u);
  for (size_t i = 1; i < study.effects.size(); ++i) EXPECT_LE(study.effects[i - 1].p_holm, study.effects[i].p_holm);
  EXPECT_NEAR(study.effects[0].p_holm, std::min(1.0, study.effects[0].p * 48), 1e-12);
}

TEST(StudyEffects, AsManySeedsAsItSaysAndNoFewerCanMakeOneOfManyComparisonsSure) {
  constexpr double kConfidence = 0.95;
  for (const size_t comparisons : {1, 7, 96, 500}) {
    const auto surest = [&](size_t seeds) {
      std::vector<double> all_agree;
      for (size_t i = 1; i <= seeds; ++i) all_agree.push_back(double(i));
      std::vector<double> p(comparisons, 1.0);
      p[0] = TestSignedRanks(all_agree).p_two_sided;
      return HolmAdjusted(p)[0];
    };
    const size_t seeds = SeedsForASureEffect(comparisons, kConfidence);
    EXPECT_LT(surest(seeds), 1 - kConfidence) << comparisons;
    EXPECT_GE(surest(seeds - 1), 1 - kConfidence) << comparisons;
    std::vector<StudyEffect> effects(comparisons);
    effects.back().walks = seeds;
    EXPECT_EQ(TooFewSeeds(effects, kConfidence), "");
    effects.back().walks = seeds - 1;
    EXPECT_THAT(TooFewSeeds(effects, kConfidence), testing::HasSubstr(std::to_string(seeds) + " seeds can make one"));
  }
}

// Hollander & Wolfe, table of the signed-rank distribution: for n = 10 and 95.1 % the 9th smallest and largest of the
// 55 means; for n = 5 not even the extremes reach 95 %.
TEST(ShiftInterval, TakesTheOrderStatisticsOfTheExactDistribution) {
  std::vector<double> differences, means;
  for (int i = 0; i < 10; ++i) differences.push_back(std::pow(1.7, i) - 20);
  for (size_t i = 0; i < 10; ++i)
    for (size_t j = i; j < 10; ++j) means.push_back(0.5 * (differences[i] + differences[j]));
  std::sort(means.begin(), means.end());
  const ConfidenceInterval interval = ShiftInterval(differences, 0.95);
  EXPECT_NEAR(interval.low, means[8], 1e-12);
  EXPECT_NEAR(interval.high, means[46], 1e-12);
  const ConfidenceInterval around_zero = ShiftInterval({-3, -1, -1, 0, 0, 0, 0, 1, 1, 3}, 0.95);
  EXPECT_EQ(around_zero.low, -1);  // exactly, not next to it
  EXPECT_EQ(around_zero.high, 1);
  EXPECT_TRUE(std::isnan(ShiftInterval({1, 2, 3, 4, 5}, 0.95).low));
  EXPECT_TRUE(std::isnan(ShiftInterval({}, 0.95).high));
  EXPECT_NEAR(ShiftInterval({1, 2, 3, 4, 5, 6}, 0.95).low, 1, 1e-12);
}

// A 95 % interval must hold the true shift in about 95 % of cases: here in 400 of them, whose standard error is 1.1 %.
TEST(ShiftInterval, HoldsTheTrueShiftAsOftenAsItSays) {
  for (const int n : {12, 60}) {  // the exact and the normal branch
    RandomStream random(3, "coverage");
    int held = 0;
    for (int trial = 0; trial < 400; ++trial) {
      std::vector<double> differences;
      for (int i = 0; i < n; ++i) differences.push_back(random.Normal(0.3, 1));
      const ConfidenceInterval interval = ShiftInterval(differences, 0.95);
      held += interval.low <= 0.3 && 0.3 <= interval.high;
    }
    EXPECT_NEAR(held / 400.0, 0.955, 0.033) << n;  // three standard errors
  }
}

TEST(ShiftInterval, TenThousandPairsTakeNoTimeAndNoMemory) {
  RandomStream random(1, "many");
  std::vector<double> differences;
  for (int i = 0; i < 10000; ++i) differences.push_back(random.Normal(1, 1));
  const ConfidenceInterval interval = ShiftInterval(differences, 0.95);
  EXPECT_NEAR(interval.low, 0.98, 0.02);
  EXPECT_NEAR(interval.high, 1.02, 0.02);
}

TEST(StudySummary, MediansOverSeedsWithTheirInterval) {
  const MadeUpStudy study;
  const std::string csv = SummaryCsv(study.table, {});
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 24 * 3);
  EXPECT_THAT(csv, testing::StartsWith("camera.exposure_ms,gait.preset,system,metric,unit,runs,n,median,low,high\n"
                                       "0,slow,sift_vo,coverage_ratio,,6,6,1,1,1\n"));
  EXPECT_THAT(csv, testing::HasSubstr("\n33,brisk,sift_vo,ate_sim3_rmse_m,m,6,3,"));
  EXPECT_EQ(csv, SummaryCsv(study.table, {}));  // its bootstrap is seeded
}

// The median's interval over ten runs each of a few walks must hold the true median about as often as it says; that of
// 120 runs taken for independent ones would hold it in less than half of all cases.
TEST(StudySummary, AnIntervalOverRunsThatShareWalksIsThatOfTheWalks) {
  RandomStream random(6, "clusters");
  constexpr int kStudies = 300;
  int held = 0;
  for (int i = 0; i < kStudies; ++i) {
    const StudyTable table = SharedWalks(12, random);
    std::vector<const StudyRun*> runs;
    for (const StudyRun& run : table.runs) {
      if (run.levels[0] == 0) runs.push_back(&run);
    }
    StudyStatistics quick;
    quick.resamples = 300;
    const MedianRow row = SummarizeRuns(runs, "ate_rmse_m", quick, "clusters");
    EXPECT_EQ(row.n, 120u);
    EXPECT_EQ(row.walks, 12u);
    held += row.interval.low <= 3 && 3 <= row.interval.high;
  }
  // A percentile interval of few values is somewhat narrow; the standard error of the count is 1.5 % of all.
  EXPECT_GT(held, 0.86 * kStudies);
}

}  // namespace
}  // namespace gaitcam
