// Ctrl-C on a real terminal, or its end: the program stops at the next whole frame and leaves what is finished, marked
// as interrupted.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Ten minutes: no test waits for its end.
const char* const kLongWalk = R"(
duration_s: 600
camera: {exposure_ms: 3, rate_hz: 10}
video: {rate_hz: 2}
score: {min_coverage_ratio: 0}
)";

/// The program on a pseudo-terminal, where it shows its bar and where a key reaches it as a signal.
class TerminalProgram {
 public:
  TerminalProgram(const std::string& arguments, const fs::path& folder, bool minds_hangup = true) {
    const std::string command =
        "cd " + folder.string() + " && GAITCAM_DATA=" + TestData().string() + " exec " + Program() + " " + arguments;
    child_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (child_ == 0) {
      signal(SIGHUP, minds_hangup ? SIG_DFL : SIG_IGN);  // whatever the tests run under
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
  }
  ~TerminalProgram() {
    if (running_) kill(child_, SIGKILL);
    Wait();
    Hangup();
  }

  /// Reads on until the bar has counted `count`; false if the program ends before or takes too long.
  bool WaitForCount(int count) {
    const std::regex counter(R"(\] (\d+)/)");
    while (ReadSome()) {
      int last = 0;
      for (std::sregex_iterator match(said_.begin(), said_.end(), counter), end; match != end; ++match) {
        last = std::stoi((*match)[1]);
      }
      if (last >= count) return true;
    }
    return false;
  }

  void PressCtrlC() const { ASSERT_EQ(write(terminal_, "\x03", 1), 1); }

  /// As where its window is closed.
  void Hangup() {
    if (terminal_ >= 0) close(std::exchange(terminal_, -1));
  }

  int ExitCode() {
    while (terminal_ >= 0 && ReadSome()) {
    }
    return Wait();
  }

  const std::string& said() const { return said_; }

 private:
  bool ReadSome() {
    pollfd ready{terminal_, POLLIN, 0};
    char text[4096];
    if (poll(&ready, 1, 20000) <= 0) return false;  // silent for 20 s: hanging
    const ssize_t count = read(terminal_, text, sizeof text);
    if (count > 0) said_.append(text, size_t(count));
    return count > 0;
  }

  int Wait() {
    if (!running_) return -1;
    int status = 0;
    waitpid(child_, &status, 0);
    running_ = false;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }

  int terminal_ = -1;
  pid_t child_ = -1;
  bool running_ = true;
  std::string said_;
};

class InterruptTest : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(File("walk.yaml")) << kLongWalk; }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }

  /// Starts the program, presses Ctrl-C when `count` frames are done, and expects it to say how it ended.
  std::string Interrupt(const std::string& arguments, int count) {
    TerminalProgram program(arguments, temporary_.path());
    EXPECT_TRUE(program.WaitForCount(count)) << program.said();
    program.PressCtrlC();
    EXPECT_EQ(program.ExitCode(), 130) << program.said();
    return program.said();
  }

  /// Nothing under a temporary name, anywhere.
  void ExpectNothingHalfWritten() const {
    for (const auto& entry : fs::recursive_directory_iterator(temporary_.path())) {
      EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
      EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr(".part"))) << entry.path();
    }
  }

  const TemporaryFolder temporary_;
};

int Lines(const fs::path& file) {
  const std::string text = ReadText(file);
  return int(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(InterruptTest, ARunKeepsAndScoresTheFinishedPart) {
  const std::string said = Interrupt("run walk.yaml --out run", 40);
  EXPECT_THAT(said, HasSubstr("INTERRUPTED after"));
  ExpectNothingHalfWritten();
  const nlohmann::json scores = nlohmann::json::parse(ReadText(File("run/scores.json")));
  EXPECT_EQ(scores["run"]["status"], "interrupted");
  EXPECT_TRUE(scores.contains("scores") && scores["scores"].contains("ate_rmse_m")) << scores.dump(2);
  const int frames = scores["run"]["frames"];
  EXPECT_GE(frames, 40);
  EXPECT_LT(frames, 6000);
  EXPECT_EQ(Lines(File("run/frames.csv")), frames + 1);  // and the heading
  EXPECT_GT(Lines(File("run/estimate.txt")), 0);
  for (const char* name : {"truth.txt", "scenario.yaml", "walk.mp4"}) EXPECT_GT(fs::file_size(File("run") / name), 0u);
  EXPECT_THAT(ReadText(File("run/report.html")), HasSubstr("interrupted"));
}

TEST_F(InterruptTest, ARunTooShortToScoreIsKeptAndSaysWhyItHasNoScore) {
  const std::string said = Interrupt("run walk.yaml --out run --set score.min_coverage_ratio=1", 1);
  ExpectNothingHalfWritten();
  EXPECT_THAT(said, HasSubstr("interrupted after"));
  const nlohmann::json scores = nlohmann::json::parse(ReadText(File("run/scores.json")));
  EXPECT_EQ(scores["run"]["status"], "interrupted");
  EXPECT_NE(scores["run"].value("not_scored", ""), "");
  EXPECT_TRUE(fs::exists(File("run/report.html")));
}

TEST_F(InterruptTest, ARunWhoseTerminalIsClosedKeepsTheFinishedPart) {
  TerminalProgram program("run walk.yaml --out run", temporary_.path());
  ASSERT_TRUE(program.WaitForCount(5)) << program.said();
  program.Hangup();
  EXPECT_LT(program.ExitCode(), 1000) << "it ends by itself, not by the signal";
  ExpectNothingHalfWritten();
  EXPECT_EQ(nlohmann::json::parse(ReadText(File("run/scores.json")))["run"]["status"], "interrupted");
  EXPECT_TRUE(fs::exists(File("run/report.html")));
}

TEST_F(InterruptTest, ARunUnderNohupGoesOnWhenTheTerminalIsClosed) {
  constexpr bool kMindsHangup = false;
  TerminalProgram program("run walk.yaml --set duration_s=3 --out run", temporary_.path(), kMindsHangup);
  ASSERT_TRUE(program.WaitForCount(5)) << program.said();
  program.Hangup();
  program.ExitCode();
  EXPECT_EQ(nlohmann::json::parse(ReadText(File("run/scores.json")))["run"]["frames"], 30);
}

TEST_F(InterruptTest, ARecordingKeepsItsFramesAndCanBeTracked) {
  Interrupt("record walk.yaml --out data", 5);
  ExpectNothingHalfWritten();
  EXPECT_THAT(ReadText(File("data/walk/about.txt")), HasSubstr("interrupted at"));
  int pictures = 0;
  for (const auto& entry : fs::directory_iterator(File("data/walk/rgb"))) pictures += entry.is_regular_file();
  EXPECT_GE(pictures, 5);
  EXPECT_EQ(Lines(File("data/walk/times.txt")), pictures);
  const ProgramResult track = RunProgram("track data/walk -q --out estimate.txt", temporary_.path());
  EXPECT_EQ(track.exit_code, 3) << track.err;  // read to the end, and too short to score
  EXPECT_TRUE(fs::exists(File("estimate.txt")));
}

}  // namespace
}  // namespace gaitcam
