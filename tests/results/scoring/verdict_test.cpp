#include "results/scoring/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/random.h"
#include "results/reports/check_report.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

constexpr const char* kMetric = "ate_rmse_m";

/// One run per value, seeds counted from 1.
MeasuredEntry Entry(const std::vector<double>& values, double coverage = 1, const std::string& metric = kMetric) {
  MeasuredEntry entry{"walk", "some_vo", {}};
  for (size_t i = 0; i < values.size(); ++i) {
    MeasuredRun run;
    run.seed = i + 1;
    run.values = {{"coverage_ratio", coverage}, {metric, values[i]}};
    entry.runs.push_back(run);
  }
  return entry;
}

const std::vector<double> kBefore{0.10, 0.12, 0.09, 0.30, 0.11, 0.14, 0.10, 0.13};

std::vector<double> Shifted(double by) {
  std::vector<double> values = kBefore;
  for (double& v : values) v += by;
  return values;
}

std::vector<GatedMetric> Metrics(double margin, Better better = Better::kLower) {
  return {{kMetric, "m", better, margin, 0}};
}

/// The verdict on the metric, which stands behind that on coverage.
MetricVerdict Judge(const MeasuredEntry& before, const MeasuredEntry& now, const std::vector<GatedMetric>& metrics,
                    const GateRules& rules = {}) {
  return JudgeEntry(before, now, metrics, rules).metrics.at(1);
}

TEST(Verdict, EqualRunsPass) {
  const EntryVerdict verdict = JudgeEntry(Entry(kBefore), Entry(kBefore), Metrics(0), {});
  EXPECT_EQ(ExitCodeOf({verdict}), 0);
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kUnchanged);
  EXPECT_EQ(verdict.metrics[1].worse_by, 0);
  EXPECT_EQ(verdict.metrics[1].pairs, 8);
}

// Seven of eight seeds as before: neither the median nor a test of ranks sees the one.
TEST(Verdict, ASingleSeedFarOutsideItsHistoryIsARegression) {
  std::vector<double> now = kBefore;
  now[2] = kBefore[2] + 0.06;  // six margins
  const MetricVerdict verdict = Judge(Entry(kBefore), Entry(now), Metrics(0.01));
  EXPECT_EQ(verdict.outcome, Outcome::kRegression);
  EXPECT_EQ(verdict.far_seeds, 1);
  EXPECT_THAT(verdict.reason, HasSubstr("seed 3: 0.15, before 0.09"));
  now[2] = kBefore[2] + 0.04;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(now), Metrics(0.01)).outcome, Outcome::kUnchanged);
  GateRules without;
  without.seed_margins = 0;
  now[2] = 1000;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(now), Metrics(0.01), without).outcome, Outcome::kUnchanged);
}

TEST(Verdict, WhatASeedDidBeforeIsNotFarOutside) {
  MeasuredEntry before = Entry(kBefore);
  before.runs[2].history[kMetric] = {0.08, 0.12, std::nan(""), 0.09};
  std::vector<double> now = kBefore;
  now[2] = 0.16;  // seven margins from the baseline's value, four from the worst re-run
  EXPECT_EQ(Judge(before, Entry(now), Metrics(0.01)).outcome, Outcome::kUnchanged);
  now[2] = 0.18;
  EXPECT_EQ(Judge(before, Entry(now), Metrics(0.01)).outcome, Outcome::kRegression);
}

TEST(Verdict, ASeedThatIsNeverTheSameTwiceIsNotJudgedByItself) {
  MeasuredEntry before = Entry(kBefore);
  before.runs[2].history[kMetric] = {0.09, 0.15};  // six margins
  std::vector<double> now = kBefore;
  now[2] = 100;
  const EntryVerdict verdict = JudgeEntry(before, Entry(now), Metrics(0.01), {});
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kUnchanged);
  EXPECT_EQ(verdict.restless, std::vector<uint64_t>{3});
  EXPECT_THAT(CheckTable({"s", {verdict}, {}, 8, 0, 1}), HasSubstr("not judged by themselves"));
  now[3] = 100;
  EXPECT_EQ(Judge(before, Entry(now), Metrics(0.01)).outcome, Outcome::kRegression);
  EXPECT_TRUE(JudgeEntry(before, Entry(now), Metrics(0), {}).restless.empty());  // no margin, no measure of spread
  GateRules pairs_alone;
  pairs_alone.seed_margins = 0;
  EXPECT_TRUE(JudgeEntry(before, Entry(now), Metrics(0.01), pairs_alone).restless.empty());
}

// A scale that went from 3 % to 0 is another one, as is one from 0 to 3 %.
TEST(Verdict, WhereAnyChangeCountsBothDirectionsDo) {
  std::vector<GatedMetric> metrics = Metrics(0.01, Better::kNearZero);
  EXPECT_EQ(Judge(Entry(kBefore), Entry(Shifted(-0.03)), metrics).outcome, Outcome::kImprovement);
  metrics[0].change = true;
  for (const double by : {-0.03, 0.03}) {
    const MetricVerdict verdict = Judge(Entry(kBefore), Entry(Shifted(by)), metrics);
    EXPECT_EQ(verdict.outcome, Outcome::kRegression) << by;
    EXPECT_NEAR(verdict.worse_by, 0.03, 1e-12) << by;
  }
  std::vector<double> now = kBefore;
  now[3] -= 0.06;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(now), metrics).outcome, Outcome::kRegression);
}

TEST(Verdict, ASeedFarBetterIsNone) {
  std::vector<double> now = kBefore;
  now[3] = 0.01;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(now), Metrics(0.01)).outcome, Outcome::kUnchanged);
}

TEST(Verdict, EverySeedWorseBeyondTheMarginIsARegression) {
  const MetricVerdict verdict = Judge(Entry(kBefore), Entry(Shifted(0.02)), Metrics(0.01));
  EXPECT_EQ(verdict.outcome, Outcome::kRegression);
  EXPECT_NEAR(verdict.worse_by, 0.02, 1e-12);
  EXPECT_EQ(verdict.p_worse, 1.0 / 256);
}

TEST(Verdict, ASmallLossIsNoneHoweverSignificant) {
  EXPECT_EQ(Judge(Entry(kBefore), Entry(Shifted(0.005)), Metrics(0.01)).outcome, Outcome::kUnchanged);
  EXPECT_EQ(Judge(Entry(kBefore), Entry(Shifted(0.005)), Metrics(0.004)).outcome, Outcome::kRegression);
}

TEST(Verdict, ALargeLossOfSomeSeedsIsNoneIfItMayBeLuck) {
  std::vector<double> now = kBefore;
  for (size_t i = 0; i < 5; ++i) now[i] += 0.5;
  for (size_t i = 5; i < 8; ++i) now[i] -= 0.45;
  GateRules pairs_alone;
  pairs_alone.seed_margins = 0;
  const MetricVerdict verdict = Judge(Entry(kBefore), Entry(now), Metrics(0.01), pairs_alone);
  EXPECT_GT(verdict.worse_by, 0.01);
  EXPECT_EQ(verdict.outcome, Outcome::kUnchanged);
}

TEST(Verdict, TheRelativeMarginCountsIfItIsTheLargerOne) {
  std::vector<GatedMetric> metrics = Metrics(0.01);
  metrics[0].margin_pct = 50;  // of a median of 0.115
  const MetricVerdict verdict = Judge(Entry(kBefore), Entry(Shifted(0.05)), metrics);
  EXPECT_NEAR(verdict.margin, 0.0575, 1e-12);
  EXPECT_EQ(verdict.outcome, Outcome::kUnchanged);
  EXPECT_EQ(Judge(Entry(kBefore), Entry(Shifted(0.06)), metrics).outcome, Outcome::kRegression);
}

TEST(Verdict, PairsBySeedSoThatTheOrderOfRunsDoesNotMatter) {
  RandomStream random(1, "shuffle");
  const MeasuredEntry before = Entry(kBefore), now = Entry(Shifted(0.02));
  const MetricVerdict expected = Judge(before, now, Metrics(0.01));
  for (int trial = 0; trial < 20; ++trial) {
    MeasuredEntry shuffled = now;
    for (size_t i = shuffled.runs.size() - 1; i > 0; --i)
      std::swap(shuffled.runs[i], shuffled.runs[size_t(random.Index(int(i) + 1))]);
    const MetricVerdict verdict = Judge(before, shuffled, Metrics(0.01));
    EXPECT_EQ(verdict.outcome, expected.outcome);
    EXPECT_EQ(verdict.worse_by, expected.worse_by);
    EXPECT_EQ(verdict.p_worse, expected.p_worse);
  }
}

TEST(Verdict, PairingSeesALossThatIsSmallBesideTheSpreadOverSeeds) {
  const MetricVerdict verdict = Judge(Entry(kBefore), Entry(Shifted(0.012)), Metrics(0.01));
  EXPECT_LT(verdict.worse_by, (verdict.before.high - verdict.before.low) / 10);
  EXPECT_EQ(verdict.outcome, Outcome::kRegression);
}

TEST(Verdict, DirectionFollowsTheMetric) {
  const MeasuredEntry before = Entry(kBefore), more = Entry(Shifted(0.05));
  EXPECT_EQ(Judge(before, more, Metrics(0.01, Better::kLower)).outcome, Outcome::kRegression);
  EXPECT_EQ(Judge(before, more, Metrics(0.01, Better::kHigher)).outcome, Outcome::kImprovement);
  EXPECT_EQ(Judge(more, before, Metrics(0.01, Better::kHigher)).outcome, Outcome::kRegression);
}

TEST(Verdict, WhatShouldBeOneIsWorseOnEitherSideOfIt) {
  const std::vector<double> near{1.001, 0.999, 1.002, 0.998, 1.001, 1.0, 0.999, 1.001};
  for (const double factor : {0.98, 1.02}) {
    std::vector<double> off = near;
    for (double& v : off) v *= factor;
    const MetricVerdict verdict = Judge(Entry(near), Entry(off), Metrics(0.005, Better::kNearOne));
    EXPECT_EQ(verdict.outcome, Outcome::kRegression) << factor;
    EXPECT_NEAR(verdict.worse_by, 0.019, 0.002) << factor;
    EXPECT_EQ(Judge(Entry(off), Entry(near), Metrics(0.005, Better::kNearOne)).outcome, Outcome::kImprovement);
  }
  // From 2 % too much to 2 % too little: as wrong as before.
  const std::vector<double> above(8, 1.02), below(8, 0.98);
  EXPECT_EQ(Judge(Entry(above), Entry(below), Metrics(0.005, Better::kNearOne)).outcome, Outcome::kUnchanged);
}

TEST(Verdict, WhatShouldBeZeroIsWorseOnEitherSideOfIt) {
  const std::vector<double> before(8, -1), now(8, 5);
  const MetricVerdict verdict = Judge(Entry(before), Entry(now), Metrics(1, Better::kNearZero));
  EXPECT_EQ(verdict.outcome, Outcome::kRegression);
  EXPECT_NEAR(verdict.worse_by, 4, 1e-12);
}

TEST(Verdict, TooFewPairsNeverPass) {
  const std::vector<double> few(kBefore.begin(), kBefore.begin() + 6);
  const EntryVerdict verdict = JudgeEntry(Entry(few), Entry(few), Metrics(0.01), {});
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kTooFewPairs);
  EXPECT_EQ(ExitCodeOf({verdict}), 3);
  EXPECT_THAT(verdict.metrics[1].reason, HasSubstr("at least 7"));
  GateRules rules;
  rules.min_pairs = 9;
  EXPECT_EQ(ExitCodeOf({JudgeEntry(Entry(kBefore), Entry(kBefore), Metrics(0.01), rules)}), 3);
}

TEST(Verdict, NothingEvaluatedNeverPasses) {
  EXPECT_EQ(ExitCodeOf({}), 3);
  EXPECT_EQ(ExitCodeOf({JudgeEntry(Entry({}), Entry({}), Metrics(0.01), {})}), 3);
}

TEST(Verdict, FewestPairsAreThoseThatCanBeSignificant) {
  EXPECT_EQ(FewestPairs(0.05), 5);   // 1 / 32
  EXPECT_EQ(FewestPairs(0.01), 7);   // 1 / 128
  EXPECT_EQ(FewestPairs(0.125), 3);  // 1 / 8 exactly
  EXPECT_EQ(FewestPairs(0.5), 1);
}

TEST(Verdict, ARunThatIsNotScoredAnyMoreIsALossOfCoverageWhateverTheAccuracy) {
  MeasuredEntry now = Entry(Shifted(-0.05));
  now.runs[2].state = RunState::kNotScored;
  now.runs[2].reason = "the estimate covers 4 % of the frames";
  now.runs[2].values = {{"coverage_ratio", 0.04}};
  const EntryVerdict verdict = JudgeEntry(Entry(kBefore), now, Metrics(0.01), {});
  EXPECT_EQ(verdict.metrics[0].outcome, Outcome::kRegression);
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kNotJudged) << "an improvement of the rest is not to be believed";
  ASSERT_EQ(verdict.lost.size(), 1u);
  EXPECT_EQ(verdict.lost[0].seed, 3u);
  EXPECT_THAT(verdict.metrics[0].reason, HasSubstr("seed 3: the estimate covers 4 %"));
  EXPECT_EQ(ExitCodeOf({verdict}), 1);
}

TEST(Verdict, ACrashIsShownWithItsReason) {
  MeasuredEntry now = Entry(kBefore);
  now.runs[0].state = RunState::kCrashed;
  now.runs[0].reason = "the process died of signal 11";
  now.runs[0].values.clear();
  const EntryVerdict verdict = JudgeEntry(Entry(kBefore), now, Metrics(0.01), {});
  EXPECT_EQ(ExitCodeOf({verdict}), 1);
  EXPECT_THAT(verdict.metrics[0].reason, HasSubstr("signal 11"));
}

TEST(Verdict, ARunThatCoversFarLessThanBeforeIsLost) {
  MeasuredEntry now = Entry(kBefore);
  now.runs[7].values["coverage_ratio"] = 0.3;
  EXPECT_EQ(JudgeEntry(Entry(kBefore), now, Metrics(0.01), {}).metrics[0].outcome, Outcome::kRegression);
  now.runs[7].values["coverage_ratio"] = 0.6;  // one seed, and not so much less: may be luck
  EXPECT_EQ(JudgeEntry(Entry(kBefore), now, Metrics(0.01), {}).metrics[0].outcome, Outcome::kUnchanged);
}

TEST(Verdict, AllowedLossesAreLeftOutAndCounted) {
  MeasuredEntry now = Entry(Shifted(0.02));
  now.runs[4].state = RunState::kNotScored;
  now.runs[4].values.clear();
  GateRules rules;
  rules.lost_runs_allowed = 1;
  const EntryVerdict verdict = JudgeEntry(Entry(kBefore), now, Metrics(0.01), rules);
  EXPECT_EQ(verdict.metrics[0].outcome, Outcome::kUnchanged);
  EXPECT_EQ(verdict.metrics[1].pairs, 7);
  EXPECT_EQ(verdict.metrics[1].left_out, 1);
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kRegression);
}

TEST(Verdict, LessCoverageOfAllSeedsIsARegression) {
  EXPECT_EQ(JudgeEntry(Entry(kBefore, 1.0), Entry(kBefore, 0.9), Metrics(0.01), {}).metrics[0].outcome,
            Outcome::kRegression);
  EXPECT_EQ(JudgeEntry(Entry(kBefore, 1.0), Entry(kBefore, 0.99), Metrics(0.01), {}).metrics[0].outcome,
            Outcome::kUnchanged);
}

TEST(Verdict, RunsThatNeverWereScoredAreNoNewLoss) {
  MeasuredEntry before = Entry(kBefore);
  before.runs[1].state = RunState::kNotScored;
  before.runs[1].values = {{"coverage_ratio", 0.05}};
  const EntryVerdict same = JudgeEntry(before, before, Metrics(0.01), {});
  EXPECT_EQ(ExitCodeOf({same}), 0);
  EXPECT_EQ(same.metrics[1].pairs, 7);
  EXPECT_EQ(same.metrics[1].left_out, 1);
}

TEST(Verdict, ASystemWithoutPosesIsJudgedByItsOtherMetrics) {
  const auto without_poses = [](MeasuredEntry entry) {
    for (MeasuredRun& run : entry.runs) run.values.erase("coverage_ratio");
    return entry;
  };
  const MeasuredEntry before = without_poses(Entry(kBefore));
  const EntryVerdict same = JudgeEntry(before, before, Metrics(0.01), {});
  EXPECT_EQ(ExitCodeOf({same}), 0);
  EXPECT_TRUE(std::isnan(same.metrics[0].now.median)) << "there is no coverage to show";
  EXPECT_EQ(ExitCodeOf({JudgeEntry(before, without_poses(Entry(Shifted(0.02))), Metrics(0.01), {})}), 1);
  // One that had poses and has none any more has lost all.
  EXPECT_EQ(ExitCodeOf({JudgeEntry(Entry(kBefore), before, Metrics(0.01), {})}), 1);
}

TEST(Verdict, AValueThatVanishesFromScoredRunsIsARegression) {
  MeasuredEntry now = Entry(kBefore);
  now.runs[3].values[kMetric] = std::numeric_limits<double>::quiet_NaN();
  const MetricVerdict verdict = Judge(Entry(kBefore), now, Metrics(0.01));
  EXPECT_EQ(verdict.outcome, Outcome::kRegression);
  EXPECT_THAT(verdict.reason, HasSubstr("1 of 8 runs no longer determine it"));
}

TEST(Verdict, AnImprovementBeyondTheMarginPassesAndAsksForANewBaseline) {
  const EntryVerdict verdict = JudgeEntry(Entry(kBefore), Entry(Shifted(-0.03)), Metrics(0.01), {});
  EXPECT_EQ(verdict.metrics[1].outcome, Outcome::kImprovement);
  EXPECT_TRUE(HasImproved({verdict}));
  EXPECT_EQ(ExitCodeOf({verdict}), 0);
  EXPECT_THAT(CheckSummary({"s", {verdict}, {}, 8, 0, 1}), HasSubstr("--update"));
}

TEST(Verdict, TheBootstrapAgreesOnClearCases) {
  GateRules rules;
  rules.test = PairedTest::kBootstrap;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(Shifted(0.02)), Metrics(0.01), rules).outcome, Outcome::kRegression);
  EXPECT_EQ(Judge(Entry(kBefore), Entry(kBefore), Metrics(0.01), rules).outcome, Outcome::kUnchanged);
  std::vector<double> half = kBefore;
  for (size_t i = 0; i < 8; ++i) half[i] += i % 2 == 0 ? 0.5 : -0.4;
  rules.seed_margins = 0;
  EXPECT_EQ(Judge(Entry(kBefore), Entry(half), Metrics(0.01), rules).outcome, Outcome::kUnchanged);
}

TEST(Verdict, PureChanceRaisesFewAlarms) {
  // Without a margin the level alone decides: 1000 draws of 8 pairs, 1 % and three sigma.
  RandomStream random(2, "chance");
  int alarms = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::vector<double> before, now;
    for (int i = 0; i < 8; ++i) {
      before.push_back(random.Normal());
      now.push_back(random.Normal());
    }
    alarms += Judge(Entry(before), Entry(now), Metrics(0)).outcome == Outcome::kRegression;
  }
  EXPECT_LE(alarms, 10 + 3 * std::sqrt(10));
}

CheckReport ReportOfAll() {
  MeasuredEntry lost = Entry(kBefore);
  lost.scenario = "odd <\"&'> name";
  lost.runs[0].state = RunState::kCrashed;
  lost.runs[0].reason = "said <nothing> & | died";
  const MeasuredEntry few = Entry({0.1, 0.2});
  return {"smoke",
          {JudgeEntry(Entry(kBefore), Entry(Shifted(0.05)), Metrics(0.01), {}),
           JudgeEntry(Entry(kBefore), lost, Metrics(0.01), {}), JudgeEntry(few, few, Metrics(0.01), {})},
          {"rendered by something else"},
          18,
          2,
          3.5};
}

TEST(CheckReport, JUnitIsWellFormedAndCountsFailuresErrorsAndSkips) {
  const std::string xml = CheckJUnit(ReportOfAll());
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(xml.c_str()), tinyxml2::XML_SUCCESS) << document.ErrorStr();
  EXPECT_THAT(xml, HasSubstr("tests=\"6\" failures=\"2\" errors=\"2\" skipped=\"1\""));
  EXPECT_THAT(xml, HasSubstr("said &lt;nothing&gt; &amp; | died"));
}

TEST(CheckReport, MarkdownRowsHaveEquallyManyCells) {
  const std::string markdown = CheckMarkdown(ReportOfAll());
  std::istringstream lines(markdown);
  std::string line;
  int rows = 0;
  while (std::getline(lines, line)) {
    if (line.empty() || line[0] != '|') continue;
    ++rows;
    size_t bars = 0;
    for (size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    EXPECT_EQ(bars, 11u) << line;
  }
  EXPECT_EQ(rows, 8);
}

TEST(CheckReport, TheSpreadOverSeedsStandsBesideEveryVerdict) {
  const std::string table = CheckTable(ReportOfAll());
  EXPECT_THAT(table, HasSubstr("0.1150 (0.09000..0.3000)"));
  EXPECT_THAT(table, HasSubstr("REGRESSION"));
  EXPECT_THAT(table, HasSubstr("lost: odd <\"&'> name with some_vo, seed 1: said <nothing> & | died"));
}

}  // namespace
}  // namespace gaitcam
