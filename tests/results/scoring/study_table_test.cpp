// The tables of a study as text.

#include "results/scoring/study_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/results/study_table_made_up.h"

namespace gaitcam {
namespace {

TEST(StudyTable, OneRowPerRunWithEmptyFieldsForWhatIsNotKnown) {
  MadeUpStudy study(1);
  study.table.runs[1].status = "failed";
  study.table.runs[1].failure = "it said \"no\", twice";
  study.table.runs[1].scores.clear();
  study.table.runs[1].blur_median_px = NAN;
  study.table.runs[1].frames = 0;
  const std::string csv = RunsCsv(study.table);
  EXPECT_THAT(csv, testing::StartsWith("camera.exposure_ms,gait.preset,system,seed,hash,status,failure,blur_median_px,"
                                       "frames,coverage_ratio,ate_sim3_rmse_m,rotation_gain\n0,slow,sift_vo,1,h0,"));
  EXPECT_THAT(csv, testing::HasSubstr("\n0,slow,mobif_vo_plus,1,h1,failed,\"it said \"\"no\"\", twice\",,0,,,\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 24);
}

TEST(StudyTable, NumbersReadBackAsTheyWere) {
  for (const double value : {0.1, 1.0 / 3, 1e-17, 123456789.125, -0.0}) EXPECT_EQ(std::stod(CsvNumber(value)), value);
  EXPECT_EQ(CsvNumber(NAN), "");
  EXPECT_EQ(CsvNumber(INFINITY), "");
}

TEST(StudyTable, TimingsStandApart) {
  MadeUpStudy study(1);
  study.table.runs[0].timing["track_ms_mean"] = 12.5;
  EXPECT_THAT(RunsCsv(study.table), testing::Not(testing::HasSubstr("track_ms")));
  EXPECT_THAT(TimingsCsv(study.table), testing::HasSubstr("seed,hash,track_ms_mean\n0,slow,sift_vo,1,h0,12.5\n"));
}

TEST(StudyAxis, TitlesHaveWordsAndUnits) {
  EXPECT_EQ((StudyAxis{"camera.exposure_ms", {}}).Title(), "exposure, ms");
  EXPECT_EQ((StudyAxis{"gait.step_length_m", {}}).Title(), "step length, m");
  EXPECT_EQ((StudyAxis{"gait.preset", {}}).Title(), "gait preset");
  EXPECT_EQ((StudyAxis{"system", {}}).Title(), "system");
}

TEST(StudyAxis, IsNumericOnlyIfAllOfItsLevelsAre) {
  EXPECT_THAT((StudyAxis{"a", {"0", "2.5", "1e3"}}).Numbers(), testing::ElementsAre(0, 2.5, 1000));
  EXPECT_THAT((StudyAxis{"a", {"0", "10 ms"}}).Numbers(), testing::IsEmpty());
}

}  // namespace
}  // namespace gaitcam
