#include "results/reports/study_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/results/study_table_made_up.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

StudyTable TwoSystems() {
  StudyTable table;
  table.name = "two";
  table.axes = {{"gait.preset", {"normal", "brisk"}, 0}, {"system", {"a", "b"}, 0}};
  table.metrics = {{"ate_rmse_m", 0, "m", "position error", Better::kLower},
                   {"rotation_gain", 0, "", "turn", Better::kNearOne},
                   {"coverage_ratio", 0, "", "coverage", Better::kHigher}};
  table.seeds = 3;
  for (size_t gait = 0; gait < 2; ++gait) {
    for (size_t system = 0; system < 2; ++system) {
      for (uint64_t seed = 1; seed <= 3; ++seed) {
        StudyRun run;
        run.levels = {gait, system};
        run.seed = seed;
        run.status = "finished";
        run.blur_median_px = gait == 0 ? 2 : 7.5;
        run.scores["coverage_ratio"] = 0.5;
        const bool is_scored = gait == 0 || system == 0 || seed == 2;
        if (is_scored) run.scores["ate_rmse_m"] = 0.01 * double(seed) + (system == 0 ? 0 : 0.1);
        if (is_scored && system == 0) run.scores["rotation_gain"] = 1 + 0.001 * double(seed);
        table.runs.push_back(run);
      }
    }
  }
  return table;
}

TEST(StudyTables, ACellHasTheMedianAndTheExtremesOfItsRuns) {
  const std::string text = StudyTablesMarkdown(TwoSystems(), 1);
  EXPECT_THAT(text, HasSubstr("\n## ate_rmse_m, mm\n\nposition error.\n\n"
                              "| system \\ gait preset | normal | brisk |\n|---|---|---|\n"
                              "| a | 20 (10 to 30) | 20 (10 to 30) |\n"));
  EXPECT_THAT(text, HasSubstr("| a | 1.002 (1.001 to 1.003) | 1.002 (1.001 to 1.003) |\n"));
  EXPECT_THAT(text, HasSubstr("\n## blur_median_px, px\n"));
  EXPECT_THAT(text, HasSubstr("| a | 2 (2 to 2) | 7.50 (7.50 to 7.50) |\n"));  // three digits, whole numbers as such
  EXPECT_THAT(text, HasSubstr("\n## coverage_ratio, %\n"));
  EXPECT_THAT(text, HasSubstr("| b | 50 (50 to 50) | 50 (50 to 50) |\n"));
}

TEST(StudyTables, ACellSaysHowManyOfItsRunsHaveTheScore) {
  const std::string text = StudyTablesMarkdown(TwoSystems(), 1);
  EXPECT_THAT(text, HasSubstr("| b | 120 (110 to 130) | 120 (120 to 120) [1] |\n"));
  EXPECT_THAT(text, HasSubstr("| b | - | - |\n"));  // no gain at all
}

TEST(StudyTables, LongPathsStayInMetres) {
  StudyTable table = TwoSystems();
  table.runs[0].scores["ate_rmse_m"] = 12.5;
  EXPECT_THAT(StudyTablesMarkdown(table, 1), HasSubstr("\n## ate_rmse_m, m\n"));
}

TEST(StudyTables, AStudyOfOneAxisIsOneTable) {
  StudyTable table = TwoSystems();
  table.axes = {{"condition", {"a|b", "c"}, 0}};
  table.runs.resize(6);
  for (StudyRun& run : table.runs) run.levels = {run.levels[1]};
  const std::string text = StudyTablesMarkdown(table, {});
  EXPECT_THAT(text,
              HasSubstr("| condition | blur_median_px, px | ate_rmse_m, mm | rotation_gain | coverage_ratio, % |\n"
                        "|---|---|---|---|---|\n| a\\|b | 2 (2 to 2) | 20 (10 to 30) | "));
  EXPECT_THAT(text, HasSubstr("\n| c | 2 (2 to 2) | 120 (110 to 130) | - | 50 (50 to 50) |\n"));
}

/// Twelve conditions of a system do not fit across: the exposures go down.
TEST(StudyTables, NoTableIsTooWide) {
  const MadeUpStudy study;
  const std::string text = StudyTablesMarkdown(study.table, 2);
  EXPECT_THAT(text, HasSubstr("| exposure, ms; system \\ gait preset | slow | normal | brisk |\n"));
  EXPECT_THAT(text, HasSubstr("\n| 33, mobif_vo_plus | "));
}

TEST(StudyTables, WhatFailedIsCounted) {
  StudyTable table = TwoSystems();
  table.runs[4].status = "failed";
  table.runs[4].scores.clear();
  EXPECT_THAT(StudyTablesMarkdown(table, 1), HasSubstr("12 runs, 3 seeds for each condition; 1 failed; 11 finished."));
}

}  // namespace
}  // namespace gaitcam
