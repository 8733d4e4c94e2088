// A study on a real Slurm of one node.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/scenarios/jobs/slurm_cluster.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class SlurmTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { cluster_ = new SlurmCluster; }
  static void TearDownTestSuite() {
    delete cluster_;
    cluster_ = nullptr;
  }
  void SetUp() override {
    if (!cluster_->trouble().empty()) GTEST_SKIP() << cluster_->trouble();
    std::ofstream(Path("walk.yaml"))
        << "scene: plain\nduration_s: 2\npath: {kind: circle, diameter_m: 4}\n"
           "score: {min_coverage_ratio: 0, min_pairs: 3}\n"
           "camera: {rate_hz: 10, width_px: 160, height_px: 120, exposure_ms: 0, fixed_subframes: 1}\n";
    std::ofstream(Path("study.yaml"))
        << "base: walk.yaml\naxes: {system: [orb_vo, akaze_vo]}\nseeds: 2\nmetrics: [coverage_ratio]\n";
  }

  fs::path Path(const std::string& name) const { return temporary_.path() / name; }
  std::string Command(const std::string& more) const {
    return cluster_->Slurm() + "GAITCAM_DATA=" + TestData().string() + " " + Program() +
           " study study.yaml --cache cache --executor slurm " + more;
  }
  ProgramResult Study(const std::string& more) const { return RunShell(Command(more), temporary_.path()); }
  std::string Queue() const { return cluster_->Ask("squeue --noheader --array --format='%i %T'"); }
  std::string JobNumber() const {
    std::string number;
    for (int i = 0; i < 200 && number.empty(); ++i) {
      std::ifstream(Path("out/runs/slurm/job")) >> number;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return number;
  }

  static SlurmCluster* cluster_;  // for all tests: its daemons take seconds to start
  const TemporaryFolder temporary_;
};
SlurmCluster* SlurmTest::cluster_ = nullptr;

TEST_F(SlurmTest, AJobArrayGivesTheTableThatThisMachineGives) {
  const ProgramResult there = Study("--out out --json");
  ASSERT_EQ(there.exit_code, 0) << there.err;
  EXPECT_EQ(nlohmann::json::parse(there.out).at("reused"), 0);
  EXPECT_THAT(cluster_->Ask("scontrol --oneliner show jobs"), HasSubstr("ArrayTaskId=3"));
  EXPECT_THAT(cluster_->Ask("scontrol --oneliner show jobs"), HasSubstr("JobName=gaitcam-study"));
  ASSERT_EQ(RunProgram("study study.yaml --cache other --out here -q", temporary_.path()).exit_code, 0);
  EXPECT_EQ(ReadText(Path("out/runs.csv")), ReadText(Path("here/runs.csv")));
  const ProgramResult again = Study("--out out --json");
  EXPECT_EQ(nlohmann::json::parse(again.out).at("reused"), 4);
}

TEST_F(SlurmTest, TasksThatSlurmEndsAreFailuresWithItsReason) {
  std::thread somebody([this] {
    const std::string number = JobNumber();
    cluster_->Ask("scancel " + number);
  });
  const ProgramResult result = Study("--out out -q --sbatch=--hold");
  somebody.join();
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_THAT(result.err, HasSubstr("4 of 4 runs failed: "));
  EXPECT_THAT(result.err, HasSubstr("CANCELLED"));
  EXPECT_THAT(ReadText(Path("out/runs.csv")), HasSubstr(",failed,"));
  EXPECT_EQ(Study("--out out -q").exit_code, 0);  // the same command does what is missing
  EXPECT_THAT(ReadText(Path("out/runs.csv")), Not(HasSubstr(",failed,")));
}

TEST_F(SlurmTest, CtrlCCancelsTheJob) {
  const ProgramResult result =
      RunShell(Command("--out out --sbatch=--hold") +
                   " & while [ ! -e out/runs/slurm/job ]; do sleep 0.1; done; sleep 0.5; kill -INT $!; wait $!",
               temporary_.path());
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_THAT(result.err, HasSubstr("cancelled Slurm job"));
  EXPECT_THAT(result.err, HasSubstr("0 of 4 runs are done"));
  EXPECT_EQ(Queue(), "");
}

TEST_F(SlurmTest, AKilledStudyFindsItsJobAgain) {
  setenv("GAITCAM_DATA", TestData().c_str(), 1);
  setenv("SLURM_CONF", cluster_->configuration().c_str(), 1);
  std::string number;
  {
    Subprocess study({Program(), "study", Path("study.yaml").string(), "--out", Path("out").string(), "--cache",
                      Path("cache").string(), "--executor", "slurm", "--sbatch=--hold", "-q"},
                     Path("said"));
    number = JobNumber();
  }  // SIGKILL
  ASSERT_THAT(Queue(), HasSubstr(number + "_3 PENDING")) << ReadText(Path("said"));
  cluster_->Ask("scontrol release " + number);
  const ProgramResult result = Study("--out out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("waiting for Slurm job " + number + " of an earlier call"));
  EXPECT_THAT(result.out, HasSubstr("4 runs (4 reused)"));
}

TEST_F(SlurmTest, WhatSlurmDoesNotTakeIsOneLineAndExitFour) {
  const ProgramResult result = Study("--out out -q --sbatch=--partition=nowhere");
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_THAT(result.err, HasSubstr("Slurm does not take the job: "));
  EXPECT_THAT(result.err, HasSubstr("Invalid partition"));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST(WithoutSlurm, ItIsOneLineAndExitFour) {
  const TemporaryFolder temporary;
  std::ofstream(temporary.path() / "study.yaml") << "base: walk.yaml\naxes: {system: [orb_vo]}\n";
  std::ofstream(temporary.path() / "walk.yaml") << "duration_s: 2\n";
  const ProgramResult result = RunShell("PATH=/nowhere GAITCAM_DATA=" + TestData().string() + " " + Program() +
                                            " study study.yaml --cache cache --executor slurm",
                                        temporary.path());
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("gaitcam: there is no sbatch on this machine; install Slurm"));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(fs::exists(temporary.path() / "studies"));
}

}  // namespace
}  // namespace gaitcam
