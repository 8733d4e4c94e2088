// A robot learns a way in the lab, and drives by what it learned: the whole path from film to film, with the program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kRobot = R"(
robot: omni_base
scene: lab
start: [-1.2, -2.25, 0]
seed: 1
camera: {width_px: 320, height_px: 240, hfov_deg: 60, rate_hz: 5, exposure_ms: 5, pitch_deg: 0, depth: true, depth_model: structured_light, antialias: 1}
sensors: {odometry: {rate_hz: 50}}
video: {enabled: false}
)";

/// 1.6 m straight ahead, learned once for all tests.
class DriveRunTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    std::ofstream(File("learn.yaml"))
        << kRobot << "duration_s: 0\ndrive: {speed_mps: 0.4}\n"
        << "path: {kind: straight, length_m: 1.6, head_tilt_rad: 0, settle_s: 0.2}\nsystem: {name: hybrid_slam, "
        << kSensitive << "}\n";
    std::ofstream(File("drive.yaml")) << kRobot
                                      << "duration_s: 12\npath: {kind: straight, length_m: 1.6, head_tilt_rad: 0}\n"
                                      << "map: learned\nsystem: {name: hybrid_drive, goal_x_m: 1.2, " << kSensitive
                                      << "}\n";
    learned_ = Run("run learn.yaml --out learned");
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path File(const std::string& name) { return folder_->path() / name; }
  static ProgramResult Run(const std::string& words) { return RunProgram(words, folder_->path()); }
  static double ScoreOf(const std::string& run, const std::string& name) {
    const nlohmann::json scores = nlohmann::json::parse(ReadText(File(run) / "scores.json"))["scores"];
    return scores.at(name).is_null() ? std::nan("") : scores[name].get<double>();
  }

  // A small picture has few features: the weaker ones count as well.
  static constexpr const char* kSensitive = "sensitivity: 20";
  static inline TemporaryFolder* folder_ = nullptr;
  static inline ProgramResult learned_;
};

TEST_F(DriveRunTest, ReachesItsGoalByTheMapThatARunWrote) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  ASSERT_TRUE(fs::exists(File("learned/route.map")));
  const ProgramResult drive = Run("run drive.yaml --out driven");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_THAT(drive.out, HasSubstr("drive_goal_reached"));
  EXPECT_EQ(ScoreOf("driven", "drive_goal_reached"), 1);
  // Features of a picture of 320 px are off by a pixel, 5 mm at a wall 3 m away, and models hold a dozen.
  EXPECT_LT(ScoreOf("driven", "drive_deviation_mean_m"), 0.02);
  EXPECT_LT(ScoreOf("driven", "drive_goal_error_m"), 0.08);
  EXPECT_LT(ScoreOf("driven", "drive_time_s"), 8) << "the run ends at the goal";
  EXPECT_THAT(ReadText(File("driven/report.html")), HasSubstr("Drive by the taught map"));
  EXPECT_THAT(ReadText(File("driven/drive.csv")), HasSubstr(",arrived,"));
}

TEST_F(DriveRunTest, StopsForAPersonWhoComesAndStandsInItsWay) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  std::ofstream(File("people.yaml")) << ReadText(File("drive.yaml"))
                                     << "people: [{name: guest, path: [[0.4, -1.2], [0.3, -2.25]], speed_m_s: 1}]\n";
  const ProgramResult drive = Run("run people.yaml --out blocked");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_EQ(ScoreOf("blocked", "drive_goal_reached"), 0);
  EXPECT_GT(ScoreOf("blocked", "drive_waited_s"), 5);
  EXPECT_EQ(ScoreOf("blocked", "drive_touches"), 0);
  EXPECT_GT(ScoreOf("blocked", "drive_clearance_m"), 0.3);
}

TEST_F(DriveRunTest, FindsItselfAgainWhenItWasCarriedOff) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  std::ofstream(File("kidnapped.yaml")) << ReadText(File("drive.yaml"))
                                        << "kidnap: {at_s: 3, to: [-1.1, -2.2, 5], over_s: 1.5}\n";
  const ProgramResult drive = Run("run kidnapped.yaml --out kidnapped --set duration_s=20");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_EQ(ScoreOf("kidnapped", "drive_goal_reached"), 1);
  // The whole map is searched after twelve frames at 5 Hz that nothing confirmed: some of them pass in the air.
  EXPECT_LT(ScoreOf("kidnapped", "drive_refound_s"), 12.0 / 5 + 1);
  EXPECT_LT(ScoreOf("kidnapped", "drive_mistaken_m"), 0.3 * (12.0 / 5 + 1));
  EXPECT_LT(ScoreOf("kidnapped", "drive_goal_error_m"), 0.08);
}

TEST_F(DriveRunTest, AHumanoidWalksTheWayThatItLearned) {
  const std::string humanoid = " --set robot=nimbro --set start=[-1.2,-1.4,0] --set path.settle_s=1";
  const ProgramResult learned = Run("run learn.yaml --out learned_on_foot --set path.length_m=1.4" + humanoid);
  ASSERT_EQ(learned.exit_code, 0) << learned.err;
  EXPECT_EQ(ScoreOf("learned_on_foot", "coverage_ratio"), 1);
  const ProgramResult drive =
      Run("run drive.yaml --out walked --set map=learned_on_foot --set duration_s=30 " + humanoid +
          " --set system.goal_x_m=1 --set system.lateral_gain=0.4 " + "--set system.heading_gain=0.6");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_EQ(ScoreOf("walked", "drive_goal_reached"), 1);
  // It sways by 3 cm to either side at every step, and stands where a step ends.
  EXPECT_LT(ScoreOf("walked", "drive_deviation_mean_m"), 0.05);
  EXPECT_LT(ScoreOf("walked", "drive_goal_error_m"), 0.1);
  EXPECT_EQ(ScoreOf("walked", "drive_waited_s"), 0) << "nothing is in its way: it takes the floor for the floor";
}

TEST_F(DriveRunTest, ARobotInTheDarkStandsAndTheScoresSaySo) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  const ProgramResult drive = Run("run drive.yaml --out dark --set duration_s=2 --set camera.exposure_ms=0.01");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_EQ(ScoreOf("dark", "drive_goal_reached"), 0);
  EXPECT_GT(ScoreOf("dark", "drive_searched_s"), 1);
}

TEST_F(DriveRunTest, ASecondSessionGoesOnWithTheMapOfTheFirst) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  const std::string another_day = "--seed 2 --set start=[-1.1,-2.2,3] --set variation.light_ratio=0.3";
  const ProgramResult second = Run("run learn.yaml --out both --set map=learned --all " + another_day);
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(ScoreOf("both", "route_sessions"), 2);
  EXPECT_GE(ScoreOf("both", "route_joins"), 5);
  EXPECT_EQ(ScoreOf("both", "route_joins_false"), 0);
  EXPECT_LT(ScoreOf("both", "route_error_rmse_m"), 0.03);
  const ProgramResult drive = Run("run drive.yaml --out driven_by_both --set map=both");
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_EQ(ScoreOf("driven_by_both", "drive_goal_reached"), 1);
  EXPECT_LT(ScoreOf("driven_by_both", "drive_deviation_mean_m"), 0.02);
}

TEST_F(DriveRunTest, AMapThatIsMissingDamagedOrOfAnotherCameraIsRefusedInOneLine) {
  ASSERT_EQ(learned_.exit_code, 0) << learned_.err;
  const auto refused = [&](const std::string& words, const std::string& part) {
    const ProgramResult result = Run("run drive.yaml --out refused " + words);
    EXPECT_EQ(result.exit_code, 2) << words;
    EXPECT_THAT(result.err, HasSubstr(part)) << words;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(File("refused"))) << words;
  };
  refused("--set map=nowhere", "there is no map");
  refused("--set system.goal_y_m=2", "the goal is off the map");
  refused("--set camera.hfov_deg=70", "learned with a camera of 320 x 240 px");
  refused("--set camera.depth=false --set camera.depth_model=ideal", "depth");
  refused("--system mobif_vo_plus", "takes no map");
  std::string bytes = ReadText(File("learned/route.map"));
  std::ofstream(File("cut.map"), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  refused("--set map=cut.map", "cut.map: it is damaged or cut off");
}

}  // namespace
}  // namespace gaitcam
