// `gaitcam study` as its users meet it: real walks, real processes, and `kill -9` at any moment.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "algorithms/core/random.h"
#include "scenarios/code/systems/subprocess.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Two seconds of a small film that needs no blur, where no texture needs painting: less than a second of work.
constexpr const char* kWalk =
    "scene: plain\nduration_s: 2\npath: {kind: circle, diameter_m: 4}\n"
    "score: {min_coverage_ratio: 0, min_pairs: 3}\n"
    "camera: {rate_hz: 10, width_px: 160, height_px: 120, exposure_ms: 0, fixed_subframes: 1}\n"
    "system: orb_vo\n";

class StudyTest : public testing::Test {
 protected:
  StudyTest() {
    Write("walk.yaml", kWalk);
    Write("study.yaml",
          "base: walk.yaml\naxes:\n  camera.exposure_ms: [0, 4]\n  system: [orb_vo, akaze_vo]\nseeds: [3]\n"
          "metrics: [coverage_ratio, ate_sim3_rmse_m]\n");
  }

  void Write(const std::string& name, const std::string& text) const { std::ofstream(Path(name)) << text; }
  fs::path Path(const std::string& name) const { return temporary_.path() / name; }
  ProgramResult Study(const std::string& arguments) const {
    return RunProgram("study " + arguments + " --cache cache", temporary_.path());
  }
  /// One line with `fragment`, the exit code, and no folder made.
  void ExpectRefusal(const std::string& yaml, const std::string& fragment, int code = 2, const std::string& more = "") {
    Write("bad.yaml", yaml);
    const ProgramResult result = Study("bad.yaml " + more);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(Path("studies"))) << yaml;
    EXPECT_FALSE(fs::exists(Path("cache"))) << yaml;
  }

  const TemporaryFolder temporary_;
};

TEST_F(StudyTest, WritesATidyTablePerRunAndWhatItMeans) {
  const ProgramResult result = Study("study.yaml --out out --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("runs"), 4);
  EXPECT_EQ(json.at("conditions"), 4);
  EXPECT_EQ(json.at("reused"), 0);
  // exposure overall and within two systems, the system: four of two scores, each of the final and of the live answer
  EXPECT_EQ(json.at("effects").size(), 16);
  const std::string runs = ReadText(Path("out/runs.csv"));
  EXPECT_THAT(runs, testing::StartsWith("camera.exposure_ms,system,seed,hash,status,failure,blur_median_px,frames,"));
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 5);
  EXPECT_THAT(runs, HasSubstr("\n4,akaze_vo,3,"));
  for (const char* name : {"summary.csv", "effects.csv", "tables.md", "timings.csv", "report.html", "study.yaml"})
    EXPECT_GT(ReadText(Path("out") / name).size(), 50u) << name;

  const ProgramResult again = Study("study.yaml --out out --json");
  EXPECT_EQ(nlohmann::json::parse(again.out).at("reused"), 4);
  EXPECT_EQ(ReadText(Path("out/runs.csv")), runs);
}

/// All processes whose command line has a word that begins with `folder`.
int ProcessesAt(const fs::path& folder) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string words = ReadText(entry.path() / "cmdline");
    count += words.find(folder.string()) != std::string::npos ? 1 : 0;
  }
  return count;
}

/// What has its name is whole; what is not whole has another one.
void ExpectOnlyWholeResults(const fs::path& out) {
  if (!fs::exists(out / "runs")) return;
  for (const auto& entry : fs::directory_iterator(out / "runs")) {
    if (entry.path().filename().string().size() != 64) continue;
    EXPECT_TRUE(nlohmann::json::accept(ReadText(entry.path() / "job.json"))) << entry.path();
  }
}

TEST_F(StudyTest, FiftyKillsLoseNothingButTheRunsInFlight) {
  ASSERT_EQ(RunProgram("study study.yaml --out reference --cache other -q", temporary_.path()).exit_code, 0);
  const std::string reference = ReadText(Path("reference/runs.csv"));
  setenv("GAITCAM_DATA", TestData().c_str(), 1);
  RandomStream random(5, "kills");
  int kills = 0, completed = 0;
  while (kills < 50) {
    const double seconds = random.Uniform() * random.Uniform() * 2.5;  // more of them early: at the planning as well
    {
      Subprocess study({Program(), "study", Path("study.yaml").string(), "--out", Path("out").string(), "--cache",
                        Path("cache").string(), "-q"},
                       Path("said"));
      if (const std::optional<Ending> ending = study.Wait(seconds)) {
        ASSERT_EQ(ending->code, 0) << ReadText(Path("said"));
        ++completed;
      } else {
        ++kills;
      }
    }  // SIGKILL
    ExpectOnlyWholeResults(Path("out"));
    if (!fs::exists(Path("out/runs.csv"))) continue;
    EXPECT_EQ(ReadText(Path("out/runs.csv")), reference);
    fs::remove_all(Path("out"));  // begin anew; every other time with the films still to be recorded
    if (completed % 2 == 0) fs::remove_all(Path("cache"));
  }
  for (int i = 0; i < 100 && ProcessesAt(Path("out")) > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(ProcessesAt(Path("out")), 0) << "a run has outlived its study";
  const ProgramResult last = Study("study.yaml --out out");
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(ReadText(Path("out/runs.csv")), reference);
  for (const auto& entry : fs::directory_iterator(Path("out")))
    EXPECT_NE(entry.path().filename().string().front(), '.') << "left behind: " << entry.path();
  RecordProperty("completed_before_the_last", completed);
}

TEST_F(StudyTest, CtrlCKeepsWhatIsDoneAndSaysHowToGoOn) {
  const ProgramResult result = RunShell("GAITCAM_DATA=" + TestData().string() + " " + Program() +
                                            " study study.yaml --out out --cache cache -q -j 1 & "
                                            "while [ ! -e out/runs/lock ]; do sleep 0.02; done; kill -INT $!; wait $!",
                                        temporary_.path());
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("runs are done, the same command goes on from there"));
  EXPECT_FALSE(fs::exists(Path("out/runs.csv")));
}

TEST_F(StudyTest, BadInputIsOneLineWithItsPlaceAndMakesNoFolder) {
  const std::string base = "base: walk.yaml\n";
  ExpectRefusal(base + "axis: {seed: [1]}\n", "bad.yaml:2:1: axis: unknown key; did you mean axes?");
  ExpectRefusal("axes: {seed: [1]}\n", "expected the key `base`");
  ExpectRefusal(base, "expected `axes` or `list`");
  ExpectRefusal(base + "axes: {}\n", "bad.yaml:2:7: axes: expected a map");
  ExpectRefusal(base + "axes: {camera.exposure_ms: []}\n", "expected a list of at least one value");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1, 1]}\n", "1 is there twice");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1, 900]}\n",
                "bad.yaml:2:32: axes.camera.exposure_ms[1]: 900 is not permitted");
  ExpectRefusal(base + "axes: {camera.exposure_mms: [1]}\n", "did you mean exposure_ms?");
  ExpectRefusal(base + "set: {duration_s: long}\naxes: {camera.exposure_ms: [1]}\n",
                "bad.yaml:2:19: set.duration_s: \"long\" is not a number");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nseeds: 0\n",
                "bad.yaml:3:8: seeds: expected a number of seeds");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nseeds: []\n", "expected at least one seed");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nseeds: many\n", "is not a whole number");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1, 2]}\nseeds: 50001\n", "100002 runs; more than 100000");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nmetrics: [ate_sim3_rmse]\n",
                "bad.yaml:3:11: metrics[0]: there is no score \"ate_sim3_rmse\"; did you mean ate_sim3_rmse_m?");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nreference: {camera.exposure_ms: 3}\n", "not a level");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nby: system\n", "not an axis of this study");
  ExpectRefusal(base + "axes: {camera.exposure_ms: [1]}\nconfidence: 95\n", "expected a number from 0.5 to 0.999");
}

TEST_F(StudyTest, WhatTheRobotCannotWalkIsSaidBeforeTheFirstRun) {
  ExpectRefusal("base: walk.yaml\naxes:\n  gait.step_length_m: [0.03, 0.3]\n",
                "bad.yaml:3:30: axes.gait.step_length_m[1]: 0.3 exceeds");
}

TEST_F(StudyTest, AProgramThatIsNotThereIsSaidBeforeTheFirstRun) {
  ExpectRefusal("base: walk.yaml\naxes:\n  system: [orb_vo, {command: [no_such_slam, \"{dataset}\", \"{output}\"]}]\n",
                "bad.yaml:3:20: axes.system[1]: system.command[0]: no_such_slam: there is no such program in PATH");
}

TEST_F(StudyTest, AFolderThatHoldsSomethingElseIsNotTouched) {
  fs::create_directory(Path("mine"));
  Write("mine/thesis.txt", "years of work");
  const ProgramResult result = Study("study.yaml --out mine");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("holds something else"));
  EXPECT_FALSE(fs::exists(Path("mine/runs")));
}

TEST_F(StudyTest, AFolderThatCannotBeWrittenIsOneLineAndExitFour) {
  const ProgramResult result = Study("study.yaml --out /proc/study");  // not even root may write there
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("cannot create the folder /proc/study"));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

// A disk without room, as far as a program can tell: no file may grow beyond 8 kB.
TEST_F(StudyTest, AFullDiskIsOneLineAndLeavesNothingHalfWritten) {
  const ProgramResult result = RunShell("trap '' XFSZ; ulimit -f 16; GAITCAM_DATA=" + TestData().string() + " " +
                                            Program() + " study study.yaml --out out --cache cache -q",
                                        temporary_.path());
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(fs::exists(Path("out/runs.csv")));
  ExpectOnlyWholeResults(Path("out"));
  const ProgramResult again = Study("study.yaml --out out -q");  // there is room again
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

// The first has a hundred walks to do, far more than the three seconds for which the second waits for its lock.
TEST_F(StudyTest, TwoStudiesInOneFolderDoNotMix) {
  setenv("GAITCAM_DATA", TestData().c_str(), 1);
  std::string seeds;
  for (int seed = 1; seed <= 100; ++seed) seeds += std::to_string(seed) + ", ";
  Write("study.yaml", "base: walk.yaml\naxes:\n  system: [orb_vo]\nseeds: [" + seeds + "]\n");
  Subprocess first({Program(), "study", Path("study.yaml").string(), "--out", Path("out").string(), "--cache",
                    Path("cache").string(), "-q", "-j", "1"},
                   Path("said"));
  for (int i = 0; i < 500 && !fs::exists(Path("out/runs/lock")); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const ProgramResult second = Study("study.yaml --out out -q");
  EXPECT_EQ(second.exit_code, 2) << second.err;
  EXPECT_THAT(second.err, HasSubstr("another gaitcam is at work in this folder"));
}

}  // namespace
}  // namespace gaitcam
