// A running program as the SLAM system of a run: what it is given, that its answers are taken as they are, and that its
// failures are its own.

#include <gmock/gmock.h>

#include "scenarios/code/systems/sandbox.h"
#include "tests/scenarios/systems/foreign_run.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kStill = "  say({'status': 'tracking', 'pose': [n, 0, 0, 0, 0, 0, 1]})\n";

class ProcessSystemTest : public ForeignRun {
 protected:
  ProgramResult RunWith(const std::string& body, const std::string& more = "") {
    WriteProgram("slam.py", Answering(body));
    return Run("{process: [./slam.py]" + more + "}");
  }
  std::string Failure() const { return ScoresOf()["run"].value("system_failed", ""); }
};

TEST_F(ProcessSystemTest, ASystemOfOursAnswersTheSameToTheBit) {
  ASSERT_EQ(Run("orb_vo", "ours").exit_code, Run("{process: [" + Program() + ", serve, orb_vo]}", "served").exit_code);
  EXPECT_EQ(ReadText(folder() / "served/estimate.txt"), ReadText(folder() / "ours/estimate.txt"));
  EXPECT_FALSE(ScoresOf("served")["run"].contains("system_failed"));
}

TEST_F(ProcessSystemTest, SeesImagesInSharedMemoryAndItsSettings) {
  // It says what it sees by where it stands: the image's mean, the number of IMU samples, a setting.
  const ProgramResult result = RunWith(
      "  if m['event'] == 'frame':\n"
      "    i = m['image']\n"
      "    with open(start['frames'], 'rb') as frames:\n"
      "      frames.seek(i['offset'])\n"
      "      pixels = frames.read(i['height'] * i['width'] * i['channels'])\n"
      "    say({'status': 'tracking', 'pose': [sum(pixels) / len(pixels) + n, len(m['imu']),\n"
      "         start['settings']['weight'], 0, 0, 0, 1]})\n"
      "  else: say({})\n",
      ", settings: {weight: 0.25}");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ScoresOf()["scores"]["coverage_ratio"], 1);
  std::istringstream rows(ReadText(folder() / "run/estimate.txt"));
  std::string row;
  while (std::getline(rows, row) && row.starts_with("#")) continue;
  double t = 0, mean = 0, samples = 0, weight = 0;
  std::istringstream(row) >> t >> mean >> samples >> weight;
  EXPECT_GT(mean, 20);
  EXPECT_LT(mean, 235);
  EXPECT_GT(samples, 0);
  EXPECT_EQ(weight, 0.25);
}

TEST_F(ProcessSystemTest, ItsLastWordCorrectsFramesAndHandsOverAMap) {
  const ProgramResult result = RunWith(
      "  if m['event'] == 'frame':\n"
      "    stamp = m['stamp_ns']\n"
      "    say({'status': 'tracking', 'pose': [n, n * n, 0, 0, 0, 0, 1]})\n"
      "  else:\n"
      "    say({'frames': [{'stamp_ns': stamp, 'status': 'tracking', 'pose': [77.5, 0, 0, 0, 0, 0, 1]}],\n"
      "         'maps': [{'landmarks': [[1, 2, 3], [4, 5, 6]]}]})\n");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(ReadText(folder() / "run/estimate.txt"), HasSubstr(" 77.5 0 0 "));
  EXPECT_TRUE(fs::exists(folder() / "run/landmarks.csv"));
}

TEST_F(ProcessSystemTest, FailuresAreItsOwnAndScored) {
  EXPECT_EQ(RunWith("  sys.exit('out of luck')\n").exit_code, 3);
  EXPECT_EQ(Failure(), "at frame 1 it exited with 1: out of luck");
  RunWith("  say({'status': 'tracking', 'pose': [n, 0, 0, 0, 0, 0, 1]}) if n < 4 else os.kill(os.getpid(), 11)\n");
  EXPECT_THAT(Failure(), HasSubstr("at frame 4 it died of signal 11"));
  EXPECT_EQ(RunWith("  print('hello', flush=True)\n").exit_code, 3);
  EXPECT_EQ(Failure(), "at frame 1 it answered no JSON: hello");
  EXPECT_EQ(RunWith("  time.sleep(100)\n", ", frame_limit_s: 0.3").exit_code, 3);
  EXPECT_EQ(Failure(), "at frame 1 it did not answer within 0.3 s");
  RunWith(
      "  say({'status': 'tracking', 'pose': [n, n * n, 0, 0, 0, 0, 1]}) if m['event'] == 'frame' else sys.exit(5)\n");
  EXPECT_EQ(Failure(), "at the end it exited with 5");
  EXPECT_EQ(ScoresOf()["scores"]["coverage_ratio"], 1) << "its answers until then stand";
}

TEST_F(ProcessSystemTest, WhatItRefusesIsToldBeforeTheWalk) {
  WriteProgram("slam.py", "#!/bin/sh\nread line\necho '{\"error\": \"slam.weight: expected a number\"}'\n");
  const ProgramResult result = Run("{process: [./slam.py]}");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("slam.weight: expected a number"));
  EXPECT_FALSE(fs::exists(folder() / "run"));
}

TEST_F(ProcessSystemTest, ASensorThatItNeedsIsAskedForBeforeTheWalk) {
  WriteProgram("slam.py", Answering(kStill));
  const ProgramResult result = Run("{process: [./slam.py], needs: [stereo]}");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr(": system: slam needs a stereo camera, which this scenario does not give it"));
  EXPECT_EQ(result.err.find("system: "), result.err.rfind("system: ")) << "said once";
}

TEST_F(ProcessSystemTest, ASystemThatActsWalksByItsCommands) {
  WriteProgram("slam.py", Answering("  say({'status': 'tracking', 'pose': [n, n * n, 0, 0, 0, 0, 1],\n"
                                    "       'command': {'velocity': [0, 0, 0]}})\n"));
  ASSERT_EQ(Run("{process: [./slam.py], acts: true}").exit_code, 0);
  const double stood = ScoresOf()["run"]["distance_m"];
  ASSERT_EQ(Run("{process: [./slam.py]}").exit_code, 0);
  const double walked = ScoresOf()["run"]["distance_m"];
  EXPECT_LT(stood, 0.5 * walked) << "it stops after the first frame";
}

TEST_F(ProcessSystemTest, ASearchFindsNoTruth) {
  if (!WhyNoSandbox().empty()) GTEST_SKIP() << WhyNoSandbox();
  temporary_.Write("earlier/truth.txt", "0 0 0 0 0 0 0 1\n");  // an earlier result in the same folder
  const ProgramResult result = RunWith(
      "  found = [os.path.join(at, name) for at, _, names in os.walk('/') for name in names\n"
      "           if ('truth' in name or name == 'subposes.csv') and not at.startswith(('/proc', '/sys', '/usr', "
      "'/lib'))]\n"
      "  for pid in os.listdir('/proc'):\n"
      "    if pid.isdigit():\n"
      "      print(pid, open('/proc/' + pid + '/cmdline').read(), file=sys.stderr)\n"
      "  print('found', found, file=sys.stderr)\n"
      "  sys.exit(1)\n");
  EXPECT_EQ(result.exit_code, 3);
  const std::string said = ReadText(folder() / "run/system.log");
  EXPECT_THAT(said, HasSubstr("found []"));
  EXPECT_THAT(said, Not(HasSubstr("s.yaml"))) << "a process of ours is to be seen";
}

}  // namespace
}  // namespace gaitcam
