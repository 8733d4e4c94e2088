// Somebody else's executable as the SLAM system of a run: what it is given, what becomes of what it says, and that its
// crashes are its own.

#include "scenarios/code/systems/command_system.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "algorithms/core/errors.h"
#include "scenarios/code/systems/sandbox.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int64_t kMs = 1000000;

Trajectory AtStamps(const std::vector<int64_t>& stamps_ms) {
  Trajectory trajectory;
  for (const int64_t ms : stamps_ms) {
    trajectory.push_back({ms * kMs, Pose(Eigen::Quaterniond::Identity(), {double(ms), 0, 0})});
  }
  return trajectory;
}

std::vector<FrameEstimate> FramesAt(const std::vector<int64_t>& stamps_ms) {
  std::vector<FrameEstimate> frames;
  for (const int64_t ms : stamps_ms) {
    frames.emplace_back();
    frames.back().stamp_ns = ms * kMs;
  }
  return frames;
}

TEST(PlaceByStamp, GivesEachFrameTheNearestPoseWithinReach) {
  std::vector<FrameEstimate> frames = FramesAt({0, 100, 200, 300});
  PlaceByStamp(AtStamps({98, 199, 201, 360}), 50 * kMs, frames);
  EXPECT_EQ(frames[0].status, TrackingStatus::kInitializing);
  EXPECT_EQ(frames[1].pose->translation.x(), 98);
  EXPECT_EQ(frames[2].pose->translation.x(), 201);  // of two equally near ones the later
  EXPECT_EQ(frames[3].status, TrackingStatus::kLost);
  EXPECT_FALSE(frames[3].pose.has_value());
}

TEST(PlaceByStamp, WithoutPosesNothingIsTracked) {
  std::vector<FrameEstimate> frames = FramesAt({0, 100});
  PlaceByStamp({}, 50 * kMs, frames);
  for (const FrameEstimate& frame : frames) EXPECT_EQ(frame.status, TrackingStatus::kInitializing);
}

TEST(FillPlaceholders, FillsEveryOneWhereverItStands) {
  EXPECT_THAT(FillPlaceholders({"slam", "--in={dataset}", "{output}", "{calibration}", "{seed}{seed}"}, "/d", "/o", 7),
              testing::ElementsAre("slam", "--in=/d", "/o", "/d/calibration.yaml", "77"));
}

class CommandSystemTest : public testing::Test {
 protected:
  /// A run of two seconds of a small film where no texture needs painting, tracked by a shell script of this text.
  ProgramResult RunWith(const std::string& script, const std::string& more = "") {
    std::ofstream(File("slam.sh")) << "#!/bin/sh\n" << script << "\n";
    fs::permissions(File("slam.sh"), fs::perms::owner_all);
    std::ofstream(File("s.yaml")) << "scene: plain\n"
                                     "duration_s: 2\n"
                                     "path: {kind: circle, diameter_m: 4}\n"
                                     "camera: {exposure_ms: 4, rate_hz: 10, width_px: 160, height_px: 120}\n"
                                     "system: {command: [./slam.sh, \"{dataset}\", \"{output}\"], format: tum"
                                  << more << "}\nvideo: {enabled: false}\n";
    return RunProgram("run s.yaml --out run", temporary_.path());
  }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }
  nlohmann::json Scores() const { return nlohmann::json::parse(ReadText(File("run") / "scores.json")); }

  const TemporaryFolder temporary_;
};

TEST_F(CommandSystemTest, SeesADatasetWithoutAnyTruthAndItsWordsAreKept) {
  // Its answer: a pose for every image, one unit further each time.
  const ProgramResult result = RunWith(
      "ls -R \"$1/..\"\n"
      "grep -v '^#' \"$1/rgb.txt\" | awk '{print $1, NR, 0, 0, 0, 0, 0, 1}' > \"$2\"");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string said = ReadText(File("run") / "system.log");
  EXPECT_THAT(said, HasSubstr("rgb.txt"));
  EXPECT_THAT(said, testing::Not(HasSubstr("truth")));
  EXPECT_EQ(Scores()["scores"]["coverage_ratio"], 1);
  EXPECT_FALSE(Scores()["run"].contains("system_failed"));
}

TEST_F(CommandSystemTest, ASearchFindsNoTruth) {
  if (!WhyNoSandbox().empty()) GTEST_SKIP() << WhyNoSandbox();
  fs::create_directories(File("earlier"));
  std::ofstream(File("earlier/truth.txt")) << "0 0 0 0 0 0 0 1\n";  // an earlier result, and a recording's truth
  std::ofstream(File("groundtruth.txt")) << "0 0 0 0 0 0 0 1\n";
  RunWith(
      "echo begin; find / \\( -path /proc -o -path /sys -o -path /usr \\) -prune -o \\( -name '*truth*' -o -name "
      "subposes.csv \\) -print; cat /proc/*/cmdline | tr '\\0' ' '; echo end; exit 1");
  const std::string said = ReadText(File("run") / "system.log");
  EXPECT_THAT(said, HasSubstr("begin\n"));
  EXPECT_THAT(said, HasSubstr("end\n"));
  EXPECT_THAT(said, testing::Not(HasSubstr("truth\n")));
  EXPECT_THAT(said, testing::Not(HasSubstr("truth.txt")));
  EXPECT_THAT(said, testing::Not(HasSubstr("run s.yaml"))) << "our own command line";
}

TEST_F(CommandSystemTest, PosesOutOfOrderAreSortedAndThatIsSaid) {
  const ProgramResult result =
      RunWith("grep -v '^#' \"$1/rgb.txt\" | awk '{print $1, NR, 0, 0, 0, 0, 0, 1}' | tac > \"$2\"");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Scores()["scores"]["coverage_ratio"], 1);
  EXPECT_THAT(result.out, HasSubstr("{output}: 19 rows are earlier than the one before: sorted by time"));
  EXPECT_THAT(ReadText(File("run") / "report.html"), HasSubstr("sorted by time"));
}

TEST_F(CommandSystemTest, ACrashIsAScoredFailure) {
  const ProgramResult result = RunWith("echo out of luck >&2; exit 7");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("slam failed: exited with 7: out of luck"));
  EXPECT_EQ(Scores()["run"]["system_failed"], "exited with 7: out of luck");
}

TEST_F(CommandSystemTest, DeathBySignalMalformedOutputAndNoOutputAreNamed) {
  EXPECT_THAT(RunWith("kill -SEGV $$").err, HasSubstr("died of signal 11"));
  EXPECT_THAT(RunWith("echo 1 2 three > \"$2\"").err, HasSubstr("wrote a malformed trajectory: {output}:1: "));
  EXPECT_THAT(RunWith("echo 0.1 nan 0 0 0 0 0 1 > \"$2\"").err, HasSubstr("wrote a malformed trajectory"));
  EXPECT_THAT(RunWith("true").err, HasSubstr("wrote no trajectory"));
}

/// Whether a process runs whose command line holds `word`.
bool IsRunning(const std::string& word) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    if (ReadText(entry.path() / "cmdline").find(word) != std::string::npos) return true;
  }
  return false;
}

TEST_F(CommandSystemTest, WhatDoesNotEndIsKilledWithItsChildren) {
  // One child in its process group, and one that has left group and session.
  const ProgramResult result = RunWith("sleep 98765.4 & setsid sleep 98765.4 & wait", ", time_limit_s: 0.5");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("did not end within 0.5 s"));
  EXPECT_FALSE(IsRunning("98765.4"));
}

TEST_F(CommandSystemTest, WhatItLeavesBehindIsKilled) {
  RunWith("setsid sleep 98765.3 & exit 1");
  EXPECT_FALSE(IsRunning("98765.3"));
}

TEST_F(CommandSystemTest, InheritsNoOpenFilesOfOurs) {
  RunWith("ls -l /proc/self/fd >&2; exit 1");
  const std::string said = ReadText(File("run") / "system.log");
  EXPECT_THAT(said, HasSubstr("-> /dev/null"));
  EXPECT_THAT(said, testing::Not(HasSubstr(".part-")));
  EXPECT_THAT(said, testing::Not(HasSubstr("truth")));
}

TEST_F(CommandSystemTest, BadCommandsAreToldBeforeAnythingRuns) {
  const auto refuse = [&](const std::string& system, const std::string& fragment) {
    std::ofstream(File("s.yaml")) << "system: " << system << "\n";
    const ProgramResult result = RunProgram("run s.yaml --out run", temporary_.path());
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, StartsWith("gaitcam: s.yaml:1:"));
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_FALSE(fs::exists(File("run")));
  };
  refuse("{command: [./nothing, \"{dataset}\", \"{output}\"]}", "./nothing: there is no such program");
  refuse("{command: [no_such_slam_program, \"{dataset}\", \"{output}\"]}", "no such program in PATH");
  refuse("{command: [sh, \"{dataset}\"]}", "expected {output}");
  refuse("{command: []}", "expected a program");
  refuse("{command: [sh, \"{dataset}\", \"{output}\"], format: json}", "system.format");
  refuse("{command: [sh, \"{dataset}\", \"{output}\"], ratio: 0.8}", "system.ratio: unknown key");
}

TEST(Vslamlab, ArgumentsAreAddedInTheProgramsOwnStyle) {
  EXPECT_THAT(
      AddVslamlabArguments({"./slam", "settings_yaml:mine.yaml", "mode:stereo"}, "/s", "/o", VslamlabMode::kMono),
      testing::ElementsAre("./slam", "settings_yaml:mine.yaml", "mode:stereo", "sequence_path:/s",
                           "calibration_yaml:/s/calibration.yaml", "rgb_csv:/s/rgb.csv", "exp_folder:/o",
                           "exp_id:00000"));
  EXPECT_THAT(AddVslamlabArguments({"python3", "slam.py"}, "/s", "/o", VslamlabMode::kMonoImu),
              testing::IsSupersetOf({"--sequence_path", "/s", "--exp_id", "00000", "--mode", "mono-vi"}));
}

TEST(Vslamlab, KeyFramesAreReadAsTheyCome) {
  const TemporaryFolder folder;
  folder.Write("00000_KeyFrameTrajectory.csv",
               "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw\n"
               "1700000000300000000,3,0,0,0,0,0,1\n"
               "1700000000100000000,1,0,0,0,0,0,1\n"
               "1700000000100000000,9,0,0,0,0,0,1\n");
  const TrajectoryFile file = ReadKeyFrames(folder.path());
  EXPECT_EQ(file.remarks.size(), 2u) << "a row out of order, a stamp twice";
  const Trajectory& read = file.trajectory;
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].stamp_ns, 1700000000100000000);
  EXPECT_EQ(read[0].pose.translation.x(), 1) << "of equal stamps the first";
  EXPECT_EQ(read[1].stamp_ns, 1700000000300000000);
  folder.Write("00000_KeyFrameTrajectory.csv", "1700000000.033333333 1 2 3 0 0 0 1\n");
  EXPECT_EQ(ReadKeyFrames(folder.path()).trajectory[0].stamp_ns, 1700000000033333333);
  folder.Write("00000_KeyFrameTrajectory.csv", "1 2 3\n");
  EXPECT_THROW(ReadKeyFrames(folder.path()), BadInput);
  folder.Write("more/KeyFrameTrajectory.txt", "");
  EXPECT_THROW(ReadKeyFrames(folder.path()), BadInput) << "which of the two?";
}

TEST_F(CommandSystemTest, ATrajectoryOfKeyFramesCoversTheirSpan) {
  // Every third frame from the fourth to the nineteenth of 20: a span of 16 frames.
  std::ofstream(File("slam.py")) << "import sys\n"
                                    "words = dict(zip(sys.argv[1::2], sys.argv[2::2]))\n"
                                    "assert words['--mode'] == 'mono', words\n"
                                    "open(words['--calibration_yaml']).read()\n"
                                    "rows = [row.split(',') for row in open(words['--rgb_csv'])][1:]\n"
                                    "with open(words['--exp_folder'] + '/00000_KeyFrameTrajectory.csv', 'w') as out:\n"
                                    "  for n in range(3, 19, 3):\n"
                                    "    print(rows[n][0], n, n * n, 0, 0, 0, 0, 1, sep=',', file=out)\n";
  std::ofstream(File("s.yaml")) << "scene: plain\n"
                                   "duration_s: 2\n"
                                   "path: {kind: circle, diameter_m: 4}\n"
                                   "camera: {exposure_ms: 4, rate_hz: 10, width_px: 160, height_px: 120}\n"
                                   "system: {command: [python3, slam.py], interface: vslamlab}\n"
                                   "score: {min_pairs: 3}\nvideo: {enabled: false}\n";
  const ProgramResult result = RunProgram("run s.yaml --out run", temporary_.path());
  ASSERT_EQ(result.exit_code, 0) << result.err << ReadText(File("run") / "system.log");
  const nlohmann::json scores = Scores();
  EXPECT_DOUBLE_EQ(scores["scores"]["coverage_ratio"], 16.0 / scores["run"]["frames"].get<double>());
  EXPECT_THAT(scores.dump(), HasSubstr("poses of 6 key frames alone"));
}

#ifdef RGBD_ODOMETRY
// OpenCV's dense RGB-D odometry is a stranger to us: that it follows sharp frames says that depth, calibration and
// stamps mean what we say they mean. Measured: 0.4 % of the path walked, scale 0.9985; with depth wrong by 2 % the
// scale is 1.019, and with grey values alone in place of depth and grey values the error is 18 %.
TEST_F(CommandSystemTest, AStrangersOdometryFindsItsWay) {
  std::ofstream(File("s.yaml")) << "duration_s: 4\n"
                                   "path: {kind: circle, diameter_m: 4}\n"
                                   "gait: {preset: normal}\n"
                                   "camera: {exposure_ms: 0, depth: true}\n"
                                   "video: {enabled: false}\n"
                                   "system: {command: ["
                                << RGBD_ODOMETRY << ", \"{dataset}\", \"{output}\"], time_limit_s: 300}\n";
  const ProgramResult result = RunProgram("run s.yaml --out run -q", temporary_.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json scores = Scores()["scores"];
  EXPECT_EQ(scores["coverage_ratio"], 1);
  EXPECT_LT(scores["ate_rmse_m"].get<double>(), 0.01 * scores["path_length_m"].get<double>());
  EXPECT_NEAR(scores["scale_ratio"].get<double>(), 1, 0.01);
}
#endif

}  // namespace
}  // namespace gaitcam
