// Programs and libraries that mean ill, or are broken in every way that we could think of, as SLAM systems. Whatever
// they do, what comes of it is a failure of theirs in one line; we go on, nothing of theirs stays, and no truth is
// reached. A new way to misbehave is one line of a table.

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "scenarios/code/systems/chosen_system.h"
#include "scenarios/code/systems/foreign_words.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/subprocess.h"
#include "tests/few_descriptors.h"
#include "tests/scenarios/systems/foreign_run.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

SystemSetup SmallSetup() {
  SystemSetup setup;
  CameraModel& camera = setup.calibration.camera;
  camera.width_px = 8;
  camera.height_px = 6;
  camera.fx = camera.fy = 7;
  setup.calibration.frame_rate_hz = 10;
  return setup;
}

/// What a system says to three small frames and at the end.
FinalEstimate Finished(System& system) {
  constexpr int kFrames = 3;
  constexpr int64_t kFrame_ns = 100'000'000;
  for (int i = 0; i < kFrames; ++i) {
    Observation o;
    o.stamp_ns = kClockStart_ns + i * kFrame_ns;
    o.exposure_ms = 5;
    o.image = {o.stamp_ns, cv::Mat::zeros(6, 8, CV_8UC1)};
    system.Track(o);
  }
  return system.Finish();
}

bool IsAnywhere(const std::string& word) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    if (ReadText(entry.path() / "cmdline").find(word) != std::string::npos) return true;
  }
  return false;
}

/// $HOME is another while it lives; none, if that is empty.
class OtherHome {
 public:
  explicit OtherHome(const std::string& home) {
    if (const char* before = std::getenv("HOME")) before_ = before;
    Set(home);
  }
  ~OtherHome() { Set(before_); }
  OtherHome(const OtherHome&) = delete;
  OtherHome& operator=(const OtherHome&) = delete;

 private:
  static void Set(const std::string& home) { home.empty() ? unsetenv("HOME") : setenv("HOME", home.c_str(), 1); }
  std::string before_;
};

class Strangers : public testing::Test {
 protected:
  /// The failure of a system, its files in our folder.
  std::string FailureOf(const std::string& choice_yaml) const {
    const SystemChoice choice = ParseSystemChoice(choice_yaml);
    SystemSetup setup = SmallSetup();
    setup.settings = choice.settings;
    const std::unique_ptr<System> system = MakeSystem(choice, setup, temporary_.path());
    return Finished(*system).failure;
  }
  std::string Program(const std::string& name, const std::string& text) const {
    const fs::path file = temporary_.Write(name, text);
    fs::permissions(file, fs::perms::owner_all);
    return file.string();
  }
  const TemporaryFolder temporary_;
};

struct Misdeed {
  std::string name;
  std::string body;     ///< Python or shell, or a word that a library knows.
  std::string failure;  ///< A part of what is said of it.
};
void PrintTo(const Misdeed& misdeed, std::ostream* out) { *out << misdeed.name; }
const auto kNameOfMisdeed = [](const auto& info) { return info.param.name; };

class StrangerProcesses : public Strangers, public testing::WithParamInterface<Misdeed> {};

TEST_P(StrangerProcesses, FailInOneLine) {
  const std::string slam = Program("slam.py", Answering(GetParam().body));
  const std::string failure =
      FailureOf("{process: [" + slam + "], start_limit_s: 20, frame_limit_s: 0.4, finish_limit_s: 0.4}");
  EXPECT_THAT(failure, HasSubstr(GetParam().failure));
  EXPECT_FALSE(IsAnywhere(slam)) << "it still runs";
}

// Within the limit of 0.4 s a machine under load may not see as much of an endless line as it may hold: then it is
// late.
INSTANTIATE_TEST_SUITE_P(
    That, StrangerProcesses,
    testing::Values(
        Misdeed{"SayBytesThatAreNoText", "  raw(b'\\xff\\xfe\\x00\\x80\\n')\n", "answered no JSON: "},
        Misdeed{"SayHalfALineAndEnd", "  raw(b'{\"status\": \"los'); sys.exit(0)\n", "at frame 1 it exited with 0"},
        Misdeed{"SayHalfALineAndWait", "  raw(b'{\"status\": \"los'); time.sleep(9)\n", "did not answer within 0.4 s"},
        Misdeed{"SayALittleForEver", "  while True: raw(b' '); time.sleep(0.01)\n", "did not answer within 0.4 s"},
        Misdeed{"SayALineWithoutEnd", "  while True: raw(b'x' * 1000000)\n", "answer"},
        Misdeed{"SayNothing", "  time.sleep(9)\n", "did not answer within 0.4 s"},
        Misdeed{"SayTwoAnswersAtOnce", "  raw(b'{\"status\": \"lost\"}\\n' * 2)\n",
                "at frame 2 it said something that it was not asked: {\"status\": \"lost\"}"},
        Misdeed{"SayNaN", "  raw(b'{\"status\": \"tracking\", \"pose\": [NaN, 0, 0, 0, 0, 0, 1]}\\n')\n", "no JSON"},
        Misdeed{"SayNull", "  raw(b'null\\n')\n", "expected an object"},
        Misdeed{"GoBeyondAllBounds", "  say({'status': 'tracking', 'pose': [1e300, 0, 0, 0, 0, 0, 1]})\n",
                "within 4e+09 m"},
        Misdeed{"NestWithoutEnd", "  raw(b'[' * 100000 + b'\\n')\n", "no JSON"},
        Misdeed{"KillThemselves", "  os.kill(os.getpid(), 9)\n", "died of signal 9"},
        Misdeed{"EndInTheMiddle", "  say({'status': 'lost'}) if m['event'] == 'frame' else sys.exit(5)\n",
                "at the end it exited with 5"},
        Misdeed{"CloseTheirOutput", "  os.close(1); time.sleep(9)\n", "at frame 1 it "}),
    kNameOfMisdeed);

// The pipe to it is full before the start is told: a settings text longer than any socket holds.
TEST_F(Strangers, WhatDoesNotReadDoesNotHoldUsUp) {
  const std::string slam = Program("slam.sh", "#!/bin/sh\nexec sleep 98761.2\n");
  const std::string text(1 << 20, 'x');
  EXPECT_THAT(FailureOf("{process: [" + slam + "], start_limit_s: 0.4, settings: {text: " + text + "}}"),
              HasSubstr("at its start it did not read within 0.4 s"));
  EXPECT_FALSE(IsAnywhere("98761.2"));
}

class StrangerCommands : public Strangers, public testing::WithParamInterface<Misdeed> {};

TEST_P(StrangerCommands, FailInOneLine) {
  temporary_.Write("earlier/truth.txt", "1700000000.0 0 0 0 0 0 0 1\n1700000000.1 0 0 0 0 0 0 1\n");
  const std::string slam = Program(
      "slam.sh", "#!/bin/sh\ntruth=" + (temporary_.path() / "earlier/truth.txt").string() + "\n" + GetParam().body);
  EXPECT_THAT(FailureOf("{command: [" + slam + R"(, "{dataset}", "{output}"], time_limit_s: 5})"),
              HasSubstr(GetParam().failure));
}

// A link is followed by who reads it, and that is us: outside the sandbox, where the truth of an earlier run may lie.
INSTANTIATE_TEST_SUITE_P(
    That, StrangerCommands,
    testing::Values(Misdeed{"LinkTheirOutputToTheTruth", "ln -s $truth $2\n", "wrote no trajectory"},
                    Misdeed{"HandOverAPipe", "mkfifo $2\n", "wrote no trajectory"},
                    Misdeed{"HandOverADevice", "ln -s /dev/zero $2\n", "wrote no trajectory"},
                    Misdeed{"HandOverAFolder", "mkdir $2\n", "wrote no trajectory"},
                    Misdeed{"HandOverNoText", "head -c 100000 /dev/zero > $2\n", "malformed trajectory"},
                    Misdeed{"GoBeyondAllBounds", "echo 1700000000.1 1e300 0 0 0 0 0 1 > $2\n", "further away than"}),
    kNameOfMisdeed);

class StrangerLibraries : public Strangers, public testing::WithParamInterface<Misdeed> {
 protected:
  StrangerLibraries() {
    setenv("GAITCAM_PROGRAM", gaitcam::Program().c_str(), 1);         // it serves them
    for (const char* sanitizer : {"ASAN_OPTIONS", "TSAN_OPTIONS"}) {  // it is to die as it would without one
      const char* given = std::getenv(sanitizer);
      setenv(sanitizer, ((given == nullptr ? "" : std::string(given) + ":") + "handle_segv=0").c_str(), 1);
    }
  }
};

TEST_P(StrangerLibraries, FailInOneLine) {
  EXPECT_THAT(
      FailureOf(std::string("{plugin: ") + HOSTILE_PLUGIN + ", frame_limit_s: 0.6, deed: " + GetParam().body + "}"),
      HasSubstr(GetParam().failure));
  EXPECT_FALSE(IsAnywhere(HOSTILE_PLUGIN)) << "its host still runs";
}

INSTANTIATE_TEST_SUITE_P(That, StrangerLibraries,
                         testing::Values(Misdeed{"Throw", "throw", "at frame 2 it exited with 1: on purpose"},
                                         Misdeed{"ThrowWhatIsNoException", "throw_number", "died of signal 6"},
                                         Misdeed{"Abort", "abort", "died of signal 6"},
                                         Misdeed{"WriteToNowhere", "write_to_nowhere", "died of signal 11"},
                                         Misdeed{"Exit", "exit", "at frame 2 it exited with 0"},
                                         Misdeed{"NeverReturn", "loop", "did not answer within 0.6 s"},
                                         Misdeed{"AnswerNaN", "nan", "pose: expected 7 finite numbers"}),
                         kNameOfMisdeed);

TEST_F(Strangers, AFileOfTheirsGrowsToItsLimitAndNoFurther) {
  SubprocessStreams streams{.log = temporary_.path() / "log", .max_file_bytes = 4096};
  Subprocess program({"/bin/sh", "-c", "exec head -c 100000 /dev/zero"}, streams);
  const std::optional<Ending> ending = program.Wait(20);
  ASSERT_TRUE(ending);
  EXPECT_FALSE(ending->ok());
  EXPECT_EQ(fs::file_size(temporary_.path() / "log"), 4096U);
}

TEST_F(Strangers, AllOfTheirFilesTogetherGrowToALimit) {
  const fs::path work = temporary_.path() / "work";
  fs::create_directories(work);
  const SubprocessStreams streams{
      .log = temporary_.path() / "log", .folder = work, .max_file_bytes = 1 << 20, .max_folder_bytes = 3'000'000};
  const auto ending_of = [&](const std::string& command) {
    Subprocess program({"/bin/sh", "-c", command}, streams);
    return program.Wait(20).value_or(Ending{-1, 0, "did not end"}).ToText();
  };
  const std::string fill = "for i in 1 2 3 4 5; do mkdir -p $i; head -c 1000000 /dev/urandom > $i/file; done; ";
  EXPECT_EQ(ending_of("truncate -s 1000000 a b c d; exit 3"), "exited with 3") << "holes take nothing";
  EXPECT_EQ(ending_of(fill + "sleep 19"), "was killed: it wrote more than 3 MB of files");
  EXPECT_THAT(ending_of("exit 0"), HasSubstr("it wrote more than 3 MB of files")) << "they are still there";
}

// A folder that we could not remove would stay in memory until the machine is started anew. It is deeper than we may
// open files; and nobody but root may read it.
TEST_F(Strangers, NothingThatTheyWroteStays) {
  const FewDescriptors few(256);
  const auto ours = [] {
    std::vector<std::string> names;
    for (const fs::path& parent : {fs::temp_directory_path(), fs::path("/dev/shm")}) {
      std::error_code ignored;
      for (const auto& entry : fs::directory_iterator(parent, ignored)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("gaitcam-") && name.find("-" + std::to_string(getpid()) + "-") != std::string::npos)
          names.push_back(name);
      }
    }
    return names;
  };
  const std::string deep = "import os, time\nfor i in range(2000): os.mkdir('d'); os.chdir('d')\n";
  const std::string locked = "os.chdir(folder); os.chmod(folder, 0); time.sleep(19)\n";
  const std::string command =
      Program("slam.py", "#!/usr/bin/env python3\nimport sys, os\nfolder = os.getcwd()\n" + deep + locked);
  EXPECT_THAT(FailureOf("{command: [" + command + R"(, "{dataset}", "{output}"], time_limit_s: 20})"),
              testing::AnyOf(HasSubstr("it wrote into folders more than 64 deep"),
                             HasSubstr("it made a folder that nobody may read")));
  EXPECT_THAT(ours(), testing::IsEmpty());
}

TEST_F(Strangers, InASandboxTheyWriteWhereThereIsALimitAndNowhereElse) {
  if (!WhyNoSandbox().empty()) GTEST_SKIP() << WhyNoSandbox();
  const std::string look =
      "import os\n"
      "def size(folder): s = os.statvfs(folder); return s.f_frsize * s.f_blocks\n"
      "def writes(folder):\n"
      "  try: open(folder + '/probe', 'w').close(); return True\n"
      "  except OSError: return False\n"
      "folders = ['/', '/dev', '/etc', '/usr', '/tmp', '/dev/shm', os.environ['HOME'], os.getcwd()]\n"
      "print(*[folder if size(folder) <= " +
      std::to_string(uint64_t(ForeignMemory_mb(0) * 1e6 / 8) + 4096) +
      " else folder + ':unlimited' for folder in folders[:-1] if writes(folder)], writes(folders[-1]))\n";
  const fs::path log = temporary_.path() / "log", work = temporary_.path() / "work";
  fs::create_directories(work);
  for (const std::string set : {"/home/somebody", "/", ""}) {
    const OtherHome home(set);
    Subprocess program(Sandboxed({"/usr/bin/python3", "-c", look}, {{}, {work}, work}), log);
    EXPECT_TRUE(program.Wait(60));
    EXPECT_EQ(LastLine(log), "/tmp /dev/shm " + (set.size() > 1 ? set : "/tmp") + " True") << ReadText(log);
  }
}

class StrangersThatHoard : public Strangers, public testing::WithParamInterface<Misdeed> {};

TEST_P(StrangersThatHoard, AreKilledWithAllTheirProcesses) {
  const std::string body = "  if m['event'] == 'frame':\n    " + GetParam().body +
                           "\n  say({'status': 'lost'} if m['event'] == 'frame' else {})\n";
  const std::string slam = Program("slam.py", Answering(body));
  EXPECT_THAT(FailureOf("{process: [" + slam + "], memory_mb: 150, frame_limit_s: 20}"), HasSubstr(GetParam().failure));
  EXPECT_FALSE(IsAnywhere(slam)) << "it still runs";
}

// The second's processes have less than the limit each, in sessions of their own. What the others write lies in memory.
INSTANTIATE_TEST_SUITE_P(
    That, StrangersThatHoard,
    testing::Values(Misdeed{"WriteTooManyFiles", "[open(str(i), 'w').close() for i in range(20000)]; time.sleep(19)",
                            "at frame 1 it was killed: it wrote more than 10000 files"},
                    Misdeed{"WriteTooDeep", "[(os.mkdir('d'), os.chdir('d')) for i in range(300)]; time.sleep(19)",
                            "at frame 1 it was killed: it wrote into folders more than 64 deep"},
                    Misdeed{"TakeTooMuch", "hoard = b'x' * 200000000; time.sleep(19)",
                            "at frame 1 it was killed: it took more than 150 MB of memory"},
                    Misdeed{"TakeTooMuchInParts",
                            "[os.fork() == 0 and (os.setsid(), [b'x' * 60000000], time.sleep(19)) for i in range(4)]; "
                            "time.sleep(19)",
                            "at frame 1 it was killed: it took more than 150 MB of memory"}),
    kNameOfMisdeed);

TEST_F(Strangers, WhatTheyMayTakeOfMemoryTheyGet) {
  const std::string slam =
      Program("slam.py", Answering("  hoard = b'x' * 100000000; time.sleep(0.5)\n"
                                   "  say({'status': 'lost'} if m['event'] == 'frame' else {})\n"));
  EXPECT_EQ(FailureOf("{process: [" + slam + "], memory_mb: 250, frame_limit_s: 20}"), "");
}

TEST_F(Strangers, ACommandThatHoardsIsKilled) {
  const std::string slam =
      Program("slam.py", "#!/usr/bin/env python3\nimport time\nb = b'x' * 200000000\ntime.sleep(19)\n");
  EXPECT_EQ(FailureOf("{command: [" + slam + R"(, "{dataset}", "{output}"], time_limit_s: 20, memory_mb: 150})"),
            "was killed: it took more than 150 MB of memory");
}

// Each in a session of its own, so that only looking for them finds them.
TEST_F(Strangers, WhoStartsProcessesWithoutEndIsKilledWithAllOfThem) {
  const std::string slam =
      Program("slam.py", Answering("  if m['event'] == 'frame':\n"
                                   "    while os.fork(): pass\n"
                                   "    os.setsid(); time.sleep(19); os._exit(0)\n"
                                   "  say({'status': 'lost'} if m['event'] == 'frame' else {})\n"));
  EXPECT_EQ(FailureOf("{process: [" + slam + "], frame_limit_s: 20}"),
            "at frame 1 it was killed: it started more than 500 processes");
  EXPECT_FALSE(IsAnywhere(slam)) << "some still run";
}

class StrangersThatDouble : public Strangers, public testing::WithParamInterface<Misdeed> {};

// Each child goes on as its parent does, and never mind if the kernel refuses a process: while some are stopped, others
// are being made.
TEST_P(StrangersThatDouble, AreKilledWithAllOfTheirProcesses) {
  const std::string slam =
      Program("slam.py", Answering("  if m['event'] == 'frame':\n"
                                   "    until = time.time() + 60\n"
                                   "    while time.time() < until:\n"
                                   "      try: " +
                                   GetParam().body +
                                   "\n"
                                   "      except OSError: pass\n"
                                   "      time.sleep(0.01)\n"
                                   "    os._exit(0)\n"
                                   "  say({'status': 'lost'} if m['event'] == 'frame' else {})\n"));
  EXPECT_EQ(FailureOf("{process: [" + slam + "], frame_limit_s: 20}"), GetParam().failure);
  EXPECT_FALSE(IsAnywhere(slam)) << "some still run";
}

INSTANTIATE_TEST_SUITE_P(That, StrangersThatDouble,
                         testing::Values(Misdeed{"Stay", "os.fork()",
                                                 "at frame 1 it was killed: it started more than 500 processes"},
                                         Misdeed{"Leave", "os.fork() == 0 and os.setsid()",
                                                 "at frame 1 it was killed: it started more than 500 processes"}),
                         kNameOfMisdeed);

// What the watch cannot count in time the kernel refuses. It refuses root nothing: then another user is asked. Without
// a sandbox there is no limit to be seen.
TEST_F(Strangers, TheKernelRefusesProcessesToASandboxLongBeforeTheMachineIsFull) {
  if (!WhyNoSandbox().empty()) GTEST_SKIP() << WhyNoSandbox();
  const std::string forks =
      "import os, time\n"
      "for i in range(4000):\n"
      "  try: os.fork() == 0 and (time.sleep(20), os._exit(0))\n"
      "  except OSError: print('refused after', i, flush=True); os._exit(0)\n";
  const OtherHome home("/tmp");  // root's own is of no use to another user
  std::vector<std::string> words = Sandboxed({"/usr/bin/python3", "-c", forks}, {{}, {}, "/tmp"});
  if (geteuid() == 0)
    words.insert(words.begin(), {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--"});
  const fs::path log = temporary_.path() / "log";
  Subprocess program(words, log);
  ASSERT_TRUE(program.Wait(60));
  int started = 0;
  ASSERT_EQ(std::sscanf(LastLine(log).c_str(), "refused after %d", &started), 1) << ReadText(log);
  EXPECT_GT(started, 500) << "what the watch permits the kernel must permit as well";
}

TEST_F(Strangers, WhatTheyMayHaveOfProcessesTheyGet) {
  const std::string slam =
      Program("slam.py", Answering("  if m['event'] == 'frame':\n"
                                   "    [os.fork() == 0 and (time.sleep(0.4), os._exit(0)) for i in range(120)]\n"
                                   "    time.sleep(0.5)\n"
                                   "  say({'status': 'lost'} if m['event'] == 'frame' else {})\n"));
  EXPECT_EQ(FailureOf("{process: [" + slam + "], frame_limit_s: 20}"), "");
}

// Double forks, sessions and environments of their own: nothing that a program can do to be forgotten is enough.
TEST_F(Strangers, ChildrenThatHideAreFound) {
  Subprocess program({"/bin/sh", "-c", "env -i setsid sh -c 'sleep 98762.3 & sleep 98762.3' >/dev/null 2>&1 & exit 0"},
                     temporary_.path() / "log");
  ASSERT_TRUE(program.Wait(20));
  EXPECT_FALSE(IsAnywhere("98762.3"));
}

TEST(ForeignWords, AreOneLineOfText) {
  EXPECT_EQ(ForeignWords("plain \xc3\xa4 \xe2\x82\xac \xf0\x9f\x98\x80"),
            "plain \xc3\xa4 \xe2\x82\xac \xf0\x9f\x98\x80");
  EXPECT_EQ(ForeignWords("\x1b[31mred\n"), "?[31mred?");
  EXPECT_EQ(ForeignWords(std::string("a\0b\tc", 5)), "a?b c");
  EXPECT_EQ(ForeignWords("\xff\xc3"), "??") << "no character begins so; one that is cut off";
  EXPECT_EQ(ForeignWords("\xc0\xaf|\xed\xa0\x80|\xf4\x90\x80\x80"), "??|???|????")
      << "longer than need be; a surrogate; beyond the last";
  EXPECT_EQ(ForeignWords(std::string(5000, 'x')).size(), 1003U);
}

/// In a whole run.
class StrangersInARun : public ForeignRun {};

TEST_F(StrangersInARun, LastWordsThatAreNoTextAreAScoredFailure) {
  WriteProgram("slam.py", Answering("  sys.stderr.buffer.write(b'\\xff\\x1b[2J gone\\n'); sys.exit(3)\n"));
  const ProgramResult result = Run("{process: [./slam.py]}");
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_EQ(ScoresOf()["run"]["system_failed"], "at frame 1 it exited with 3: ??[2J gone");
}

}  // namespace
}  // namespace gaitcam
