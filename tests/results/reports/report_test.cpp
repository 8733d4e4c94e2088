// The report page, opened by a real browser: nothing complains, and every chart shows its data.

#include "results/reports/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "algorithms/core/errors.h"
#include "results/reports/report_map.h"
#include "results/reports/video.h"
#include "tests/results/reports/browser.h"
#include "tests/results/scoring/synthetic.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

/// Planks with grain: something to look at.
cv::Mat PlankPicture(int seed) {
  cv::Mat picture(240, 320, CV_8UC3), grain(24, 160, CV_8UC1);
  cv::RNG random(seed + 1);
  random.fill(grain, cv::RNG::NORMAL, 128, 30);
  cv::resize(grain, grain, picture.size(), 0, 0, cv::INTER_CUBIC);
  for (int v = 0; v < picture.rows; ++v) {
    const int plank = (v * (240 + v) / 9000) * 37 % 23;
    for (int u = 0; u < picture.cols; ++u) {
      const int g = grain.at<uchar>(v, u) - 128;
      picture.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(70 + 2 * plank + g),
                                     cv::saturate_cast<uchar>(105 + 3 * plank + g),
                                     cv::saturate_cast<uchar>(150 + 3 * plank + g)};
    }
  }
  cv::circle(picture, {60 + 25 * seed % 200, 70}, 32, {60, 60, 200}, cv::FILLED, cv::LINE_AA);
  return picture;
}

/// A made-up run of 20 s that initialises, gets lost once and drifts.
struct MadeUpRun {
  Trajectory truth = SwayingCircle(600, 2, 2 * std::numbers::pi);
  Scores scores;
  ReportInput input;

  MadeUpRun() {
    RandomStream random(7, "report");
    Similarity drifting;
    Estimate estimate;
    for (size_t i = 0; i < truth.size(); ++i) {
      drifting.scale = 0.4 * (1 + 0.0004 * double(i));
      drifting.rotation = RotZ(0.0006 * double(i));
      FrameEstimate frame;
      frame.stamp_ns = truth[i].stamp_ns;
      frame.status = i < 20 ? TrackingStatus::kInitializing
                            : (i >= 300 && i < 345 ? TrackingStatus::kLost : TrackingStatus::kTracking);
      if (frame.status == TrackingStatus::kTracking) {
        frame.pose = drifting * truth[i].pose;
        frame.pose->translation += 0.004 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
      }
      frame.features = int(400 + 100 * std::sin(0.03 * double(i)) + 20 * random.Normal());
      frame.inliers = frame.pose ? int(frame.features * (0.5 + 0.1 * std::sin(0.2 * double(i)))) : 0;
      estimate.frames.push_back(frame);
      estimate.track_ms.push_back(30 + 5 * random.Uniform());
      AddFrame(frame, int(i));
    }
    scores = ScoreEstimate(estimate, truth, Stamps(truth), {});
    input.scores = &scores;
    Describe();
  }

  void AddFrame(const FrameEstimate& frame, int i) {
    ReportFrame f;
    f.stamp_ns = frame.stamp_ns;
    f.status = frame.status;
    f.features = frame.features;
    f.inliers = frame.inliers;
    const double swing = std::pow(std::sin(0.3 * i), 2);
    f.blur_median_px = 2 + 4 * swing;
    f.blur_p90_px = 3 + 7 * swing;
    f.blur_max_px = 4 + 11 * swing + std::sin(1.7 * i);
    f.gait = GaitState{i / 10, (i % 10) / 10.0};
    f.left_contact = i % 20 < 12;
    f.right_contact = (i + 10) % 20 < 12;
    input.frames.push_back(f);
  }

  void Describe() {
    input.title = "quickstart";
    input.subtitle = "khr1hv walks a circle in lab, gait normal, 320 x 240 at 30 Hz, exposure 20 ms; sift_vo looks on";
    input.end_time_s = 20;
    input.renderer = "llvmpipe (LLVM 15.0.6, 256 bits), software, EGL device 0, OpenGL 4.5";
    input.truth = truth;
    for (int k = 0; k < 8; ++k) {
      ReportTwin twin;
      twin.stamp_ns = truth[size_t(30 + 75 * k)].stamp_ns;
      twin.sharp = PlankPicture(k);
      cv::blur(twin.sharp, twin.blurred, {3 + 2 * k, 1 + k});
      twin.blur_median_px = 2 + k;
      twin.blur_max_px = 4 + 2 * k;
      input.twins.push_back(twin);
    }
    input.resolved_scenario =
        "scenario: quickstart\nrobot: khr1hv\ngait:\n  preset: normal\n  period_s: 0.35\ncamera:\n  exposure_ms: 20\n";
    input.facts = {
        {"seed", "1"}, {"gaitcam", "0.1.0"}, {"MuJoCo", "2.2.2"}, {"command", "gaitcam run scenarios/quickstart.yaml"}};
  }
};

/// The same run by a system that mapped the floor along its way, a little off.
struct MappingRun : MadeUpRun {
  FloorComparison map;

  MappingRun() {
    FloorTruth floor;
    floor.px_per_m = 50;
    floor.corner_m = {-2.99, 4.99};
    floor.grey.create(300, 300, CV_8UC1);
    cv::RNG random(5);
    random.fill(floor.grey, cv::RNG::NORMAL, 128, 60);
    cv::GaussianBlur(floor.grey, floor.grey, {}, 2);
    cv::normalize(floor.grey, floor.grey, 20, 230, cv::NORM_MINMAX);
    const FloorPicture picture = MapAlongTheWay(floor);
    map = CompareFloor(picture, floor, {});
    input.sections.push_back(FloorReportSection(map, truth, scores.last.aligned_se3));
    scores.scores.insert(scores.scores.end(), map.scores.begin(), map.scores.end());
  }

  /// Its world is that of the truth, shifted by 4 cm.
  FloorPicture MapAlongTheWay(const FloorTruth& floor) const {
    FloorPicture picture;
    picture.cell_m = 0.02;
    picture.corner_m = floor.corner_m + Eigen::Vector2d(0.04, 0);
    floor.grey.copyTo(picture.intensity);
    picture.sightings = cv::Mat::zeros(picture.intensity.size(), CV_16UC1);
    for (const StampedPose& p : truth) {
      const Eigen::Vector2d at = (p.pose.translation.head<2>() - picture.corner_m) / picture.cell_m;
      cv::Mat disk = cv::Mat::zeros(picture.sightings.size(), CV_16UC1);
      cv::circle(disk, {int(at.x()), int(-at.y())}, 20, cv::Scalar(1), cv::FILLED);
      picture.sightings += disk;
    }
    picture.intensity.setTo(0, picture.sightings == 0);
    return picture;
  }
};

/// The same run, straight ahead instead of on a circle, by a system that jumps once.
struct StraightRun : MadeUpRun {
  StraightRun() {
    for (size_t i = 0; i < truth.size(); ++i)
      truth[i].pose = Pose(LookAlong(0), {0.01 * double(i), 0.01 * std::sin(0.6 * double(i)), 0.3});
    RandomStream random(8, "report");
    Estimate estimate = EstimateFromTrajectory(Noisy(truth, random, 0.005, 0.002));
    for (size_t i = 250; i < truth.size(); ++i) estimate.frames[i].pose->translation.y() += 0.05;
    estimate.frames[250].restarted = input.frames[250].restarted = true;
    scores = ScoreEstimate(estimate, truth, Stamps(truth), {});
    input.scores = &scores;
    input.truth = truth;
  }
};

/// Two seconds of film beside the page; its first picture is the poster.
void MakeFilm(const fs::path& path, ReportInput& input) {
  VideoWriter writer(path);
  for (int i = 0; i < 60; ++i) {
    VideoFrame frame;
    frame.camera = PlankPicture(i / 8);
    frame.bystander = PlankPicture(3);
    frame.time_s = i / 30.0;
    frame.exposure_ms = 20;
    frame.status = "tracking, 213 inliers";
    if (i == 0) input.video_poster = ComposeVideoFrame(frame, 360);
    writer.Add(frame);
  }
  writer.Finish();
  input.video_file = path.filename();
}

TEST(Report, ABrowserDrawsEveryChartLoadsTheFilmAndDoesNotComplain) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  const fs::path page = PageFolder(folder) / "report.html";
  MadeUpRun run;
  MakeFilm(page.parent_path() / "walk.mp4", run.input);
  WriteReport(page, run.input);
  // The page leaves the film alone until somebody presses play; the test loads it and notes what it says of itself.
  std::ofstream(page, std::ios::app)
      << "<script>{const v = document.querySelector('video'); v.addEventListener('loadeddata', () => {"
         "document.body.dataset.film = v.videoWidth + 'x' + v.videoHeight + ' ' + v.duration.toFixed(1); });"
         "v.preload = 'auto'; v.load();}</script>";
  const Browsed browsed = Browse(page, "--window-size=1280,1000");
  ExpectAllDrawn(browsed, "8");  // two paths, heading, two errors, blur, inliers, feet
  EXPECT_EQ(Attribute(browsed.dom, "data-film"), "962x390 2.0");
}

TEST(Report, AMapStandsBesideTheTrueFloorWithThePathsDrawnWhereTheyWent) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  const fs::path page = PageFolder(folder) / "map.html";
  const MappingRun run;
  WriteReport(page, run.input);
  // The browser says where the start of the true path and the scale bar came to lie on the map's picture.
  std::ofstream(page, std::ios::app)
      << "<script>{const ground = document.querySelector('.maps .ground'), box = ground.getBoundingClientRect();"
         "const line = ground.querySelector('polyline.true'), start = "
         "line.points[0].matrixTransform(line.getScreenCTM());"
         "const bar = ground.querySelector('.bar').getBoundingClientRect(), set = document.body.dataset;"
         "set.startX = ((start.x - box.x) / box.width).toFixed(3); set.startY = ((start.y - box.y) / "
         "box.height).toFixed(3);"
         "set.bar = (bar.width / box.width).toFixed(3); set.shown = [...document.querySelectorAll('.maps img')]"
         ".filter(i => i.naturalWidth > 0).length;}</script>";
  const Browsed browsed = Browse(page, "--window-size=1280,1000");
  ExpectAllDrawn(browsed, "8");
  EXPECT_EQ(Attribute(browsed.dom, "data-shown"), "4");
  const cv::Size size = run.map.estimate.size();
  const Eigen::Vector2d start =
      (run.truth.front().pose.translation.head<2>() - run.map.corner_m) / run.map.cell_m + Eigen::Vector2d(0.5, -0.5);
  EXPECT_NEAR(std::stod(Attribute(browsed.dom, "data-start-x")), start.x() / size.width, 0.003);
  EXPECT_NEAR(std::stod(Attribute(browsed.dom, "data-start-y")), -start.y() / size.height, 0.003);
  EXPECT_THAT(browsed.dom, HasSubstr("<span>1 m</span>"));
  EXPECT_NEAR(std::stod(Attribute(browsed.dom, "data-bar")), 1 / (size.width * run.map.cell_m), 0.003);
}

TEST(Report, WithoutAMapThereIsNoTraceOfOne) {
  const MadeUpRun without;
  const MappingRun with;
  const std::string none = ReportHtml(without.input), there = ReportHtml(with.input);
  for (const char* text : {"<code>map_ncc</code>", "Map, correlation", "on-map", "mapped", "class=\"maps\""}) {
    EXPECT_THAT(there, HasSubstr(text));
    EXPECT_THAT(none, Not(HasSubstr(text)));
  }
}

TEST(Report, ALongStraightPathIsDrawnWide) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  const fs::path page = PageFolder(folder) / "straight.html";
  const StraightRun run;
  WriteReport(page, run.input);
  const Browsed browsed = Browse(page);
  ExpectAllDrawn(browsed, "8");
  EXPECT_THAT(browsed.dom, HasSubstr(">jump</li>"));
}

TEST(Report, ARunThatFellWithoutScoresIsToldLoudlyAndStillDrawn) {
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  const fs::path page = PageFolder(folder) / "fell.html";
  MadeUpRun run;
  run.input.end = RunEnd::kFell;
  run.input.end_time_s = 3.21;
  run.input.software_renderer = true;
  run.input.scores = nullptr;
  run.input.no_scores_reason = "too little to score: 4 poses";
  WriteReport(page, run.input);
  const Browsed browsed = Browse(page, "--window-size=500,1000");
  ExpectAllDrawn(browsed, "5");  // two paths, blur, inliers, feet
  for (const char* text :
       {"fell at 3.2 s", "The robot fell after 3.2 s.", "There are no scores.", "4 poses", "Rendered in software."}) {
    EXPECT_THAT(browsed.dom, HasSubstr(text));
  }
}

TEST(Report, ABrowserThatFindsABlankChartSaysSo) {
  // The check above must be able to fail: a page whose blur is all unknown has one chart without data.
  if (!HaveChromium()) GTEST_SKIP() << "no chromium on this machine";
  const TemporaryFolder folder;
  MadeUpRun run;
  for (ReportFrame& f : run.input.frames) f.blur_median_px = f.blur_p90_px = f.blur_max_px = std::nan("");
  WriteReport(folder.path() / "report.html", run.input);
  const Browsed browsed = Browse(folder.path() / "report.html");
  EXPECT_EQ(Attribute(browsed.dom, "data-charts"), "8");
  EXPECT_EQ(Attribute(browsed.dom, "data-charts-drawn"), "7");
}

TEST(Report, SaysWhoRenderedWhoeverItWas) {
  MadeUpRun run;
  for (const char* renderer : {"llvmpipe (LLVM 15.0.6, 256 bits), software, EGL device 0", "A GPU, EGL device 1"}) {
    run.input.renderer = renderer;
    EXPECT_THAT(ReportHtml(run.input), HasSubstr(renderer));
  }
}

TEST(Report, IsOneFileThatAsksForNothingElse) {
  const MadeUpRun run;
  const std::string html = ReportHtml(run.input);
  for (const std::string attribute : {" src=\"", " href=\"", " poster=\""}) {
    for (size_t at = html.find(attribute); at != std::string::npos; at = html.find(attribute, at + 1)) {
      EXPECT_EQ(html.compare(at + attribute.size(), 5, "data:"), 0) << html.substr(at, 80);
    }
  }
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
}

TEST(Report, WordsFromOutsideCannotBecomeMarkup) {
  MadeUpRun run;
  run.input.title = "</script><script>alert(1)</script> & \"co\"";
  run.input.resolved_scenario = "note: <b>bold</b>";
  run.input.facts = {{"<i>", "</main>"}};
  const std::string html = ReportHtml(run.input);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, HasSubstr("&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;co&quot;"));
  EXPECT_THAT(html, HasSubstr("note: &lt;b&gt;bold&lt;/b&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<i>")));
}

TEST(Report, LowCoverageHasABannerAndGoodCoverageHasNone) {
  MadeUpRun run;  // 89 %
  EXPECT_THAT(ReportHtml(run.input), Not(HasSubstr("Low coverage")));
  run.input.min_good_coverage_ratio = 0.95;
  EXPECT_THAT(ReportHtml(run.input), HasSubstr("Low coverage: only 89 % of the frames have a pose."));
}

TEST(Report, AFinishedRunOnAGraphicsProcessorHasNoBanner) {
  const MadeUpRun run;
  EXPECT_THAT(ReportHtml(run.input), Not(HasSubstr("class=\"banner")));
}

TEST(Report, EveryScoreStandsInTheTable) {
  const MadeUpRun run;
  const std::string html = ReportHtml(run.input);
  for (const auto* list : {&run.scores.scores, &run.scores.timing}) {
    for (const Score& s : *list) EXPECT_THAT(html, HasSubstr("<code>" + s.name + "</code>"));
  }
}

TEST(Report, WithoutChartJsNamesTheDebianPackageAndWritesNothing) {
  const TemporaryFolder folder;
  const MadeUpRun run;
  try {
    WriteReport(folder.path() / "report.html", run.input, {.chart_library = "/nowhere/chart.min.js"});
    FAIL();
  } catch (const MissingResource& error) {
    EXPECT_THAT(error.what(), HasSubstr("libjs-chart.js"));
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Report, AnEmptyRunIsAPageAllTheSame) {
  ReportInput input;
  input.title = "nothing";
  EXPECT_THAT(ReportHtml(input), HasSubstr("There are no scores."));
}

TEST(Report, AFolderThatIsNotThereIsAMissingResource) {
  EXPECT_THROW(WriteReport("/nowhere/report.html", ReportInput()), MissingResource);
}

}  // namespace
}  // namespace gaitcam
