// Maps of the floor, from the scene's own picture to the files that a run leaves behind.

#include "scenarios/code/runs/mapped_floor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "results/scoring/score.h"
#include "scenarios/code/files/folders.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

/// A right map of the table's left half, in the world of the truth.
FloorPicture RightMap(const Scene& scene) {
  FloorPicture map;
  map.cell_m = 0.005;
  map.corner_m = {scene.floor_min.x() + 0.5 * map.cell_m, scene.floor_max.y() - 0.5 * map.cell_m};
  cv::cvtColor(FloorImage(scene, 1 / map.cell_m), map.intensity, cv::COLOR_BGR2GRAY);
  map.sightings = cv::Mat::zeros(map.intensity.size(), CV_16UC1);
  map.sightings.colRange(0, map.sightings.cols / 2).setTo(9);
  return map;
}

TEST(MappedFloor, ThePlacesOwnPictureIsARightMap) {
  const Scene scene = ReadScene("tabletop", ModelsFolder());
  Scores scores;
  scores.scores = CompareMappedFloor(RightMap(scene), scene, {}).scores;
  EXPECT_GT(scores.Value("map_ncc"), 0.98);  // each picture samples the prints' fine textures its own way
  EXPECT_NEAR(scores.Value("map_area_m2"), 6, 0.05);
  EXPECT_LT(scores.Value("map_landmark_error_p90_m"), 0.001);

  // It is the very scene that was mapped.
  const Scene lab = ReadScene("lab", ModelsFolder());
  Scores elsewhere;
  elsewhere.scores = CompareMappedFloor(RightMap(scene), lab, {}).scores;
  EXPECT_LT(elsewhere.Value("map_ncc"), 0.3);
}

TEST(MappedFloor, ThePictureOfALargeFloorIsOfLimitedSize) {
  const Scene hall = ReadScene("hall", ModelsFolder());
  const FloorTruth truth = FloorTruthOf(hall, 0.001);
  EXPECT_LE(double(truth.grey.total()), 64.1e6);
  EXPECT_NEAR((truth.Min() - hall.floor_min).norm(), 0, 2 / truth.px_per_m);
  EXPECT_NEAR((truth.Max() - hall.floor_max).norm(), 0, 2 / truth.px_per_m);
}

TEST(MappedFloor, PicturesThatCannotBeWrittenAreAMissingResource) {
  const Scene scene = ReadScene("tabletop", ModelsFolder());
  EXPECT_THROW(WriteMapPictures(CompareMappedFloor(RightMap(scene), scene, {}), "/proc/nowhere"), MissingResource);
}

/// Head down over the table's prints.
const char* const kMappingWalk = R"(
scene: tabletop
start: [0.1, -0.45, 0]
duration_s: 6
gait: {preset: normal}
path: {kind: circle, diameter_m: 0.9, head_tilt_rad: 0.3, settle_s: 0.3}
camera: {width_px: 160, height_px: 120, rate_hz: 15, exposure_ms: 6, pitch_deg: 25, fixed_subframes: 4}
system: floor_slam
video: {enabled: false}
)";

class MappingRunTest : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(temporary_.path() / "walk.yaml") << kMappingWalk; }
  ProgramResult Run(const std::string& arguments) { return RunProgram(arguments, temporary_.path()); }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }

  const TemporaryFolder temporary_;
};

TEST_F(MappingRunTest, LeavesPicturesScoresAndAReportOfTheMap) {
  const ProgramResult result = Run("run walk.yaml --out run");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("map_landmark_error_median_m"));
  const cv::Mat estimate = cv::imread(File("run/map/estimate.png"), cv::IMREAD_UNCHANGED);
  ASSERT_FALSE(estimate.empty());
  for (const char* name : {"mask", "truth", "difference"}) {
    EXPECT_EQ(cv::imread(File("run/map") / (std::string(name) + ".png"), cv::IMREAD_UNCHANGED).size(), estimate.size());
  }
  const nlohmann::json scores = nlohmann::json::parse(ReadText(File("run/scores.json")))["scores"];
  EXPECT_GT(scores["map_ncc"], 0.5);  // what it can be is the business of longer runs
  EXPECT_GT(scores["map_area_m2"], 0.1);
  EXPECT_THAT(ReadText(File("run/report.html")), HasSubstr("<h2>The floor as it was mapped</h2>"));

  const ProgramResult without = Run("run walk.yaml --out without -q --set system=mobif_vo_plus");
  ASSERT_EQ(without.exit_code, 0) << without.err;
  EXPECT_FALSE(fs::exists(File("without/map")));
  EXPECT_THAT(ReadText(File("without/scores.json")), Not(HasSubstr("map_")));
}

TEST_F(MappingRunTest, StudiesHaveTheScoresOfTheMap) {
  std::ofstream(File("study.yaml")) << "base: walk.yaml\naxes: {system: [floor_slam, mobif_vo_plus]}\nseeds: 1\n"
                                       "metrics: [map_ncc, ate_rmse_m]\n";
  const ProgramResult result = Run("study study.yaml --out study --cache cache");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream rows(ReadText(File("study/runs.csv")));
  std::string head, mapping, other;
  std::getline(rows, head);
  std::getline(rows, mapping);
  std::getline(rows, other);
  ASSERT_THAT(head, HasSubstr("map_ncc"));
  const auto column = [&](const std::string& row, const std::string& name) {
    std::istringstream heads(head), cells(row);
    std::string h, cell;
    while (std::getline(heads, h, ',') && std::getline(cells, cell, ',')) {
      if (h == name) return cell;
    }
    return std::string("no such column");
  };
  EXPECT_GT(std::stod(column(mapping, "map_ncc")), 0.5);
  EXPECT_EQ(column(other, "map_ncc"), "");
  EXPECT_NE(column(other, "ate_rmse_m"), "");
}

}  // namespace
}  // namespace gaitcam
