// Places recognised through the program itself: real scans, real views, a small grid.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const char* const kPlaces = R"(
robot: khr1hv_pan
scene: robocup_field
path: {head_tilt_rad: 0, settle_s: 0.4}
camera: {width_px: 104, height_px: 80, hfov_deg: 56.9, rate_hz: 4, pitch_deg: 0, exposure_ms: 5, fixed_subframes: 1}
localisation:
  columns: 3
  rows: 2
  field_m: [2.7, 1.8]
  queries: 6
  panorama_width_px: 360
  panorama_height_px: 80
  wavelet: {level: 3}
  methods: [wavelet, fourier]
  occlusions: [0.2]
  lights: [dimmed]
  walk_exposures_ms: [20]
  walk_m: 0.4
  walk_every_s: 0.5
  heat_maps: 1
)";

class LocalisationTest : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(temporary_.path() / "places.yaml") << kPlaces; }
  ProgramResult Run(const std::string& arguments, const std::string& cache = "cache") {
    return RunShell(
        "XDG_CACHE_HOME=$PWD/" + cache + " GAITCAM_DATA=" + TestData().string() + " " + Program() + " " + arguments,
        temporary_.path());
  }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }
  nlohmann::json Scores(const std::string& run) const {
    nlohmann::json scores = nlohmann::json::parse(ReadText(File(run) / "scores.json"));
    EXPECT_TRUE(scores.contains("timing"));
    scores.erase("timing");
    return scores;
  }
  void ExpectRefusal(const std::string& change, const std::string& fragment) {
    const ProgramResult result = Run("run places.yaml --out out --set " + change);
    EXPECT_EQ(result.exit_code, 2) << change;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(File("out")));
  }

  /// A KHR-1HV whose neck does not turn.
  void WriteStiffRobot() {
    const fs::path folder = TestData() / "models/robots/khr1hv";
    std::istringstream lines(ReadText(folder / "khr1hv.yaml"));
    std::ofstream stiff(File("stiff.yaml"));
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("neck:")) continue;
      stiff << (line.starts_with("urdf:") ? "urdf: " + (folder / "khr1hv.urdf").string() : line) << "\n";
    }
  }

  const TemporaryFolder temporary_;
};

TEST_F(LocalisationTest, LeavesATableScoresHeatMapsAndAPageThatAreTheSameAgain) {
  const ProgramResult result = Run("run places.yaml --out a");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("walk_20ms"));
  const nlohmann::json scores = Scores("a");
  EXPECT_EQ(scores["run"]["status"], "finished");
  EXPECT_EQ(scores["scores"]["references"], 6);
  EXPECT_EQ(scores["scores"]["queries"], 24);
  // Half of the pixels and level 3 of the transform: 45 x 10 squares as ever.
  EXPECT_EQ(scores["scores"]["wavelet_bytes_per_place"], 169);
  // Six places of which most are neighbours: chance finds two thirds of the views, all six of a condition once in
  // eleven tests; three conditions share their views. A heading by chance is 90 degrees off.
  double found = 0;
  for (const std::string condition : {"plain", "occlusion_20", "light_dimmed", "walk_20ms"}) {
    found += 6 * scores["scores"]["wavelet_" + condition + "_found_ratio"].get<double>();
    EXPECT_LT(scores["scores"]["wavelet_" + condition + "_bearing_error_median_deg"], 20) << condition;
  }
  EXPECT_GT(found, 22.5);  // 23 of 24
  EXPECT_NEAR(scores["scores"]["occlusion_covered_median_ratio"], 0.2, 0.01);
  EXPECT_GT(scores["scores"]["walk_blur_median_px"], 0.2);

  std::istringstream csv(ReadText(File("a/localisation.csv")));
  int lines = 0;
  for (std::string line; std::getline(csv, line); ++lines) EXPECT_EQ(std::count(line.begin(), line.end(), ','), 18);
  EXPECT_EQ(lines, 1 + 24 * 2);
  const cv::Mat map = cv::imread((File("a/heatmaps") / "plain_view_0_wavelet.png").string());
  EXPECT_GT(map.cols, 400);
  const std::string page = ReadText(File("a/report.html"));
  for (const char* text : {"occlusion_20", "light_dimmed", "walk_20ms", "data-chart=\"found\""}) {
    EXPECT_THAT(page, HasSubstr(text));
  }

  // Made anew, and from the pictures that were kept.
  ASSERT_EQ(Run("run places.yaml --out b -q", "other_cache").exit_code, 0);
  ASSERT_EQ(Run("run places.yaml --out c -q").exit_code, 0);
  for (const std::string other : {"b", "c"}) {
    EXPECT_EQ(Scores(other), scores);
    for (const char* name : {"localisation.csv", "scenario.yaml", "heatmaps/plain_view_0_wavelet.png"})
      EXPECT_EQ(ReadText(File("a") / name), ReadText(File(other) / name)) << name;
  }
}

TEST_F(LocalisationTest, WhatDoesNotFitIsRefusedInOneLineBeforeAnythingIsRendered) {
  WriteStiffRobot();
  ExpectRefusal("robot=./stiff.yaml", "stiff cannot look all around");
  ExpectRefusal("localisation.queries=2", "localisation.queries");
  ExpectRefusal("'localisation.field_m=[20, 3]'", "reaches beyond the floor of robocup_field");
  ExpectRefusal("'localisation.field_m=[0.2, 3]'", "leave nothing within the margin");
  ExpectRefusal("'localisation.methods=[wavelets]'", "did you mean wavelet?");
  ExpectRefusal("'localisation.lights=[dim]'", "dimmed");
  ExpectRefusal("'localisation.occlusions=[20]'", "localisation.occlusions");
  ExpectRefusal("localisation.walk_m=9", "walk_m");
}

TEST_F(LocalisationTest, ThereIsNoWalkToRecord) {
  const ProgramResult result = Run("record places.yaml --out data -q");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("gaitcam run"));
  EXPECT_EQ(Run("validate places.yaml -q").exit_code, 0);
}

}  // namespace
}  // namespace gaitcam
