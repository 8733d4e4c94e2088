// Whole runs through the program itself: real physics, real rendering, real files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/data_folder.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Four seconds of a walk past the lab's posters: enough for a start of the odometry and a dozen steps. Few pixels:
/// what is compared here are bytes, not accuracies.
const char* const kWalk = R"(
duration_s: 4
path: {kind: circle, diameter_m: 4}
camera: {width_px: 160, height_px: 120, exposure_ms: 6, rate_hz: 15}
score: {min_coverage_ratio: 0}
)";

/// What stays in view when a long text has scrolled by.
std::string LastLine(const std::string& text) {
  const std::string whole = text.substr(0, text.find_last_not_of('\n') + 1);
  return whole.substr(whole.rfind('\n') + 1);
}

nlohmann::json ScoresWithoutTiming(const fs::path& run) {
  nlohmann::json scores = nlohmann::json::parse(ReadText(run / "scores.json"));
  EXPECT_EQ(scores.contains("timing"), !scores["run"].contains("not_scored"));
  scores.erase("timing");
  return scores;
}

class RunTest : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(temporary_.path() / "walk.yaml") << kWalk; }
  ProgramResult Run(const std::string& arguments) { return RunProgram(arguments, temporary_.path()); }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }

  /// `run walk.yaml --out run`, made once for all tests: what it said, and where its folder `run` lies.
  struct FirstRun {
    TemporaryFolder temporary;
    ProgramResult result;
    fs::path folder = temporary.path() / "run";

    FirstRun() {
      temporary.Write("walk.yaml", kWalk);
      result = RunProgram("run walk.yaml --out run", temporary.path());
    }
  };
  static const FirstRun& First() {
    static const FirstRun first;
    return first;
  }

  const TemporaryFolder temporary_;
};

TEST_F(RunTest, LeavesEstimateTruthScoresFilmAndReport) {
  const ProgramResult& result = First().result;
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"coverage_ratio", "ate_rmse_m", "ate_sim3_rmse_m", "ate_rot_own_rmse_deg", "drift_sim3_pct",
                           "scale_ratio", "rotation_gain", "blur_median_px", "blur_p95_px", "track_ms_mean"}) {
    EXPECT_THAT(result.out, HasSubstr(name)) << name;
  }
  EXPECT_LE(std::count(result.out.begin(), result.out.end(), '\n'), 15) << result.out;
  EXPECT_THAT(result.out, testing::EndsWith("\nreport: run/report.html\n"));
  for (const char* name :
       {"estimate.txt", "truth.txt", "scores.json", "scenario.yaml", "frames.csv", "walk.mp4", "report.html"}) {
    EXPECT_TRUE(fs::exists(First().folder / name)) << name;
  }
  const nlohmann::json scores = ScoresWithoutTiming(First().folder);
  EXPECT_EQ(scores["run"]["status"], "finished");
  EXPECT_EQ(scores["run"]["frames"], 60);
  // It stands for a second, then walks at some 0.1 m/s.
  EXPECT_GT(scores["run"]["distance_m"], 0.1);
}

TEST_F(RunTest, TheSameSeedGivesTheSameBytesAndAnotherSeedDoesNot) {
  ASSERT_EQ(First().result.exit_code, 0) << First().result.err;
  ASSERT_EQ(Run("run walk.yaml --out again -q").exit_code, 0);
  for (const char* name : {"estimate.txt", "truth.txt", "scenario.yaml", "frames.csv"}) {
    EXPECT_EQ(ReadText(First().folder / name), ReadText(File("again") / name)) << name;
  }
  EXPECT_EQ(ScoresWithoutTiming(First().folder), ScoresWithoutTiming(File("again")));
  ASSERT_EQ(Run("run walk.yaml --out other -q --seed 2").exit_code, 0);
  EXPECT_NE(ReadText(First().folder / "estimate.txt"), ReadText(File("other/estimate.txt")));
}

TEST_F(RunTest, TheResolvedScenarioGivesTheSameRun) {
  ASSERT_EQ(Run("run walk.yaml --out a -q --set gait.lift_m=0.018").exit_code, 0);
  const ProgramResult again = Run("run a/scenario.yaml --out b -q");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(ReadText(File("a/estimate.txt")), ReadText(File("b/estimate.txt")));
  EXPECT_EQ(ReadText(File("a/scenario.yaml")), ReadText(File("b/scenario.yaml")));
}

TEST_F(RunTest, TheSameFramesFromMemoryAndFromDiskGiveTheSameEstimateToTheBit) {
  ASSERT_EQ(First().result.exit_code, 0) << First().result.err;
  for (const std::string format : {"tum", "euroc"}) {
    const ProgramResult record = Run("record walk.yaml -q --format " + format + " --out " + format);
    ASSERT_EQ(record.exit_code, 0) << record.err;
    const ProgramResult track = Run("track " + format + "/walk -q --out " + format + ".txt");
    ASSERT_EQ(track.exit_code, 0) << track.err;
    EXPECT_EQ(ReadText(First().folder / "estimate.txt"), ReadText(File(format + ".txt"))) << format;
  }
}

TEST_F(RunTest, TruthLiesBesideTheFolderThatASystemGets) {
  ASSERT_EQ(Run("record walk.yaml -q --set duration_s=1 --out data").exit_code, 0);
  EXPECT_TRUE(fs::exists(File("data/walk-truth/groundtruth.txt")));
  for (const auto& entry : fs::recursive_directory_iterator(File("data/walk"))) {
    EXPECT_EQ(entry.path().filename().string().find("truth"), std::string::npos) << entry.path();
  }
}

TEST_F(RunTest, TrackingThatCannotWriteItsAnswerIsRefusedBeforeTheFirstFrame) {
  ASSERT_EQ(Run("record walk.yaml -q --set duration_s=1 --out data").exit_code, 0);
  EXPECT_THAT(Run("track data/walk --out done.txt").err, testing::StartsWith("tracking walk "));
  for (const std::string out : {"data", "nowhere/e.txt", "walk.yaml/e.txt", "/proc/e.txt"}) {
    const ProgramResult refused = Run("track data/walk --out " + out);
    EXPECT_THAT(refused.exit_code, testing::AnyOf(2, 4)) << out;
    EXPECT_THAT(refused.err, testing::StartsWith("gaitcam: " + out + ": ")) << "no frame was tracked";
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  }
}

TEST_F(RunTest, AFallIsSaidAloudAndWhatWasFilmedIsKept) {
  // A gyroscope that is off by some 1 rad/s tells the balance lies.
  // It falls within two seconds, too early for a first map: somebody else's program says something of each frame.
  std::ofstream(File("steady.sh")) << "#!/bin/sh\nawk '!/^#/ {print $1, NR / 100, 0, 0, 0, 0, 0, 1}' $1/rgb.txt > $2\n";
  fs::permissions(File("steady.sh"), fs::perms::owner_all);
  std::ofstream(File("walk.yaml"), std::ios::app)
      << "sensors: {gyro_bias: 1}\nsystem: {command: [./steady.sh, \"{dataset}\", \"{output}\"]}\n";
  const ProgramResult result = Run("run walk.yaml --out run");
  ASSERT_TRUE(fs::exists(File("run/scores.json"))) << result.err;
  const nlohmann::json scores = ScoresWithoutTiming(File("run"));
  EXPECT_EQ(scores["run"]["status"], "fell");
  EXPECT_GT(scores["run"]["end_time_s"], 0);
  EXPECT_LT(scores["run"]["end_time_s"], 4);
  EXPECT_THAT(ReadText(File("run/report.html")), HasSubstr("fell"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(LastLine(result.out), HasSubstr("FELL after"));
}

TEST_F(RunTest, TooLittleCoverageIsExitCodeThreeAndNotAGoodScore) {
  const ProgramResult result =
      Run("run walk.yaml --out run --set system.name=sift_vo --set system.min_start_points=5000");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("report.html"));
  EXPECT_TRUE(ScoresWithoutTiming(File("run"))["run"].contains("not_scored"));
}

TEST_F(RunTest, ScoreOfARunsOwnFilesAgreesWithTheRun) {
  ASSERT_EQ(First().result.exit_code, 0) << First().result.err;
  const std::string words = "score " + (First().folder / "estimate.txt").string() + " " +
                            (First().folder / "truth.txt").string() + " --set min_coverage_ratio=0";
  const ProgramResult result = Run(words + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json by_files = nlohmann::json::parse(result.out), by_run = ScoresWithoutTiming(First().folder);
  EXPECT_THAT(Run(words).out, testing::Not(HasSubstr("rpe_trans_rmse_m_1s")));
  EXPECT_THAT(Run(words + " --all").out, HasSubstr("rpe_trans_rmse_m_1s"));
  for (const char* name : {"ate_rmse_m", "ate_sim3_rmse_m", "rpe_trans_rmse_m_1s"}) {
    EXPECT_EQ(by_files["scores"][name], by_run["scores"][name]) << name;
  }
}

TEST_F(RunTest, ListAndDoctorAnswer) {
  const ProgramResult list = Run("list");
  EXPECT_EQ(list.exit_code, 0) << list.err;
  for (const char* name : {"khr1hv", "robovie_m", "nimbro", "omni_base", "lab", "corridor", "hall", "tabletop", "plain",
                           "robocup_field", "sift_vo", "brisk", "quickstart"}) {
    EXPECT_THAT(list.out, HasSubstr(name));
  }
  const ProgramResult doctor = Run("doctor --json");
  EXPECT_EQ(doctor.exit_code, 0) << doctor.out;
  EXPECT_TRUE(nlohmann::json::parse(doctor.out).contains("MuJoCo"));
}

TEST_F(RunTest, EveryShippedScenarioIsValid) {
  for (const auto& entry : fs::directory_iterator(TestData() / "scenarios")) {
    if (entry.path().extension() != ".yaml") continue;
    const ProgramResult result = Run("validate " + entry.path().string());
    const bool only_wants_its_map = result.err.find("set map to the folder of a run") != std::string::npos;
    EXPECT_TRUE(result.exit_code == 0 || only_wants_its_map) << entry.path() << ": " << result.err;
  }
}

}  // namespace
}  // namespace gaitcam
