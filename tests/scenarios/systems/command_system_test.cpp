// Somebody else's executable as the SLAM system of a run: what it is given, what becomes of what it says, and that its
// crashes are its own.

#include "scenarios/code/systems/command_system.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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
  /// A run of one second of a small film, tracked by a shell script of this text.
  ProgramResult RunWith(const std::string& script, const std::string& more = "") {
    std::ofstream(File("slam.sh")) << "#!/bin/sh\n" << script << "\n";
    fs::permissions(File("slam.sh"), fs::perms::owner_all);
    std::ofstream(File("s.yaml")) << "duration_s: 2\n"
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

#ifdef RGBD_ODOMETRY
// OpenCV's direct RGB-D odometry is a stranger to us: that it follows our frames says that depth, calibration and
// stamps mean what we say they mean. It slips where the view has little texture, so the median speaks: 1.1 mm measured
// from frame to frame, of some 3.5 mm of sway and walk.
TEST_F(CommandSystemTest, AStrangersOdometryFindsItsWay) {
  std::ofstream(File("s.yaml")) << "duration_s: 4\n"
                                   "path: {kind: circle, diameter_m: 4}\n"
                                   "gait: {preset: slow}\n"
                                   "camera: {exposure_ms: 0, depth: true}\n"
                                   "video: {enabled: false}\n"
                                   "system: {command: ["
                                << RGBD_ODOMETRY << ", \"{dataset}\", \"{output}\"], time_limit_s: 300}\n";
  const ProgramResult result = RunProgram("run s.yaml --out run -q", temporary_.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json scores = Scores()["scores"];
  EXPECT_EQ(scores["coverage_ratio"], 1);
  EXPECT_LT(scores["rpe_trans_median_m_1f"].get<double>(), 0.002);
}
#endif

}  // namespace
}  // namespace gaitcam
