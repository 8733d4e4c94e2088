// The page of a study, opened by a real browser.

#include "results/reports/study_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/results/reports/browser.h"
#include "tests/results/study_table_made_up.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

fs::path WritePage(const StudyReportInput& input, const TemporaryFolder& folder, const std::string& name) {
  const fs::path page = PageFolder(folder) / name;
  std::ofstream(page) << StudyReportHtml(input);
  return page;
}

TEST(StudyReport, ABrowserDrawsEveryChartAndDoesNotComplain) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  const MadeUpStudy study;
  const Browsed browsed = Browse(WritePage(study.input, folder, "study.html"), "--window-size=1280,1000");
  ExpectAllDrawn(browsed, "9");  // three scores, each by exposure, by gait and over blur
}

TEST(StudyReport, AStudyOfOneAxisIsDrawnToo) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  MadeUpStudy study;
  study.input.by = std::nullopt;
  study.table.axes.resize(1);
  for (StudyRun& run : study.table.runs) run.levels.resize(1);
  study.effects = RankEffects(study.table, {}, std::nullopt);
  ExpectAllDrawn(Browse(WritePage(study.input, folder, "one_axis.html")), "6");
}

TEST(StudyReport, NoRunLiesBeyondTheAxesOfItsCharts) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  MadeUpStudy study;
  study.table.runs[study.table.runs.size() / 2].blur_median_px = 40;  // more than the first and the last have
  const fs::path page = WritePage(study.input, folder, "axes.html");
  std::ofstream(page, std::ios::app) << R"(<script>
    let points = 0, beyond = 0;
    for (const chart of Object.values(Chart.instances))
      for (const set of chart.data.datasets)
        for (const p of set.data) {
          const {x, y} = chart.scales;
          ++points;
          if (p.x < x.min || p.x > x.max || p.y < y.min || p.y > y.max) ++beyond;
        }
    document.body.dataset.points = points;
    document.body.dataset.beyond = beyond;
  </script>)";
  const Browsed browsed = Browse(page, "--window-size=1280,1000");
  EXPECT_EQ(browsed.complaints, "");
  EXPECT_EQ(Attribute(browsed.dom, "data-beyond"), "0");
  EXPECT_GT(std::stoi(Attribute(browsed.dom, "data-points")), 3 * int(study.table.runs.size()));
}

/// To the systems, whose axis then is one of the charts'.
void GiveLongNames(MadeUpStudy& study) {
  for (std::string& level : study.table.axes[2].levels)
    level = "system={name: " + level + ", tracker: {shutter_by_imu: false}}, camera.preset=cmos";
  study.input.by = std::nullopt;
}

TEST(StudyReport, LevelsWithLongNamesStandOneBelowTheOther) {
  MadeUpStudy study;
  const std::string wide = "<div class=\"wide\">", lying = "\"lying\":true";
  EXPECT_THAT(StudyReportHtml(study.input), AllOf(Not(HasSubstr(wide)), Not(HasSubstr(lying))));
  GiveLongNames(study);
  EXPECT_THAT(StudyReportHtml(study.input), AllOf(HasSubstr(wide), HasSubstr(lying)));
}

TEST(StudyReport, ABrowserDrawsLevelsWithLongNamesToo) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  MadeUpStudy study;
  GiveLongNames(study);
  ExpectAllDrawn(Browse(WritePage(study.input, folder, "long_names.html"), "--window-size=1280,1000"), "12");
}

TEST(StudyReport, SaysWhatTheIntervalsAndTestsAreAndHowManyRunsStandBehindThem) {
  const MadeUpStudy study;
  const std::string html = StudyReportHtml(study.input);
  for (const char* text : {"Hodges-Lehmann", "Wilcoxon", "48 comparisons (Holm)", "95 % bootstrap interval",
                           "exposure, ms", "n = 6", "3 of 6", "144"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
}

TEST(StudyReport, RunsWithoutResultAreToldLoudly) {
  MadeUpStudy study;
  for (size_t i = 0; i < 3; ++i) {
    study.table.runs[i].status = "failed";
    study.table.runs[i].failure = "the run died of signal 9 <&>";
    study.table.runs[i].scores.clear();
  }
  study.table.runs[5].status = "fell";
  const std::string html = StudyReportHtml(study.input);
  EXPECT_THAT(html, HasSubstr("3 of 144 runs failed.</b>the run died of signal 9 &lt;&amp;&gt;"));
  EXPECT_THAT(html, HasSubstr("covered too little to be scored"));
  EXPECT_THAT(html, HasSubstr("The robot fell in 1 of 144 runs."));
}

TEST(StudyReport, WordsFromOutsideCannotBecomeMarkup) {
  MadeUpStudy study;
  study.table.name = "<script>alert(1)</script>";
  study.table.axes[2].levels[0] = "</script><b>x";
  study.input.study_file = "<i>";
  const std::string html = StudyReportHtml(study.input);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("</script><b>")));
  EXPECT_THAT(html, Not(HasSubstr("<i>")));
}

}  // namespace
}  // namespace gaitcam
