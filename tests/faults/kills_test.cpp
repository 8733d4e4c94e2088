// Programs that are killed at any moment, that run twice at once, or whose clock is set back while they run. What must
// hold: the same command, given again, leaves the very files that it leaves where nothing ever happened, and nothing
// else: no half-written file, no folder of a process that is no more.
//
// GAITCAM_LONG_TESTS=1: all verbs, each killed before each of its calls that alter folders; and at GAITCAM_KILLS (100)
// random instants each.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "algorithms/core/random.h"
#include "tests/faults/inputs.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using Clock = std::chrono::steady_clock;

struct KilledVerb {
  std::string name, arguments;
  std::string output;       ///< One of the files that it writes.
  bool is_long = false;     ///< Left to the long part.
  std::string before = "";  ///< Done once, undisturbed, into the folder "recorded" that it then finds; empty: nothing.
};

const std::vector<KilledVerb>& KilledVerbs() {
  static const std::vector<KilledVerb> verbs = {
      {"score", "score estimate.txt truth.txt --out scores.json", "scores.json", false},
      {"record", "record walk.yaml --set duration_s=0.6 --out recorded", "recorded/walk/calibration.yaml", true},
      {"run", "run walk.yaml --set duration_s=0.5 --set scene=plain --set camera.fixed_subframes=1 --out done",
       "done/scores.json", false},
      {"learn", "run learn.yaml --out learned", "learned/route.map", true},
      {"study", "study study.yaml --out study --cache cache", "study/runs.csv", true},
      {"matrix", "record matrix.yaml --out matrix", "matrix/matrix.yaml", true},
      {"check", "check ./suite.yaml --update --cache cache", "baselines/suite.json", true},
      {"track", "track recorded/walk --system stereo_vo --out tracked.txt", "tracked.txt", false,
       "record walk.yaml --out recorded"},
  };
  return verbs;
}

/// The folder that holds what is recorded before the verb is killed.
const fs::path& FolderBefore(const KilledVerb& verb) {
  static std::map<std::string, TemporaryFolder> folders;
  const auto [entry, is_new] = folders.try_emplace(verb.name);
  const fs::path& folder = entry->second.path();
  if (is_new) {
    WriteInputs(folder);
    fs::create_directory(folder / "tmp");
    int status = 0;
    waitpid(StartProgram(folder, verb.before, ""), &status, 0);
    EXPECT_EQ(ExitCode(status), 0) << verb.before;
  }
  return folder;
}

/// A folder with the inputs, and the folder for temporary files in it, where what stays is seen, too.
class Workplace {
 public:
  explicit Workplace(const KilledVerb& verb) : verb_(verb) {
    WriteInputs(folder_.path());
    fs::create_directory(folder_.path() / "tmp");
    if (!verb.before.empty())
      fs::copy(FolderBefore(verb) / "recorded", folder_.path() / "recorded", fs::copy_options::recursive);
  }

  /// @param variables of its environment: "NAME=VALUE ..."
  pid_t Start(const std::string& variables = "") const {
    return StartProgram(folder_.path(), verb_.arguments, variables);
  }
  static int Wait(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return ExitCode(status);
  }
  int Run(const std::string& variables = "") const { return Wait(Start(variables)); }

  std::map<std::string, std::string> Files() const { return WhatStays(folder_.path()); }
  const fs::path& path() const { return folder_.path(); }

 private:
  const KilledVerb& verb_;
  const TemporaryFolder folder_;
};

class Kills : public testing::TestWithParam<int> {
 protected:
  static const KilledVerb& verb() { return KilledVerbs()[size_t(GetParam())]; }

  struct Undisturbed {
    int exit_code = -1;
    double seconds = 0;
    std::map<std::string, std::string> files;
  };
  static const Undisturbed& WhereNothingHappened() {
    static std::map<int, Undisturbed> known;
    Undisturbed& one = known[GetParam()];
    if (one.exit_code >= 0) return one;
    const Workplace place(verb());
    const Clock::time_point start = Clock::now();
    one.exit_code = place.Run();
    one.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    one.files = place.Files();
    return one;
  }
  /// A walk that is too short to be scored ends with 3, its results are there.
  static bool HadItsOutput() {
    const int code = WhereNothingHappened().exit_code;
    return (code == 0 || code == 3) && WhereNothingHappened().files.count(verb().output) == 1;
  }
  static void ExpectTheSameAsEver(const Workplace& place) {
    EXPECT_EQ(place.Run(), WhereNothingHappened().exit_code);
    EXPECT_EQ(Changed(WhereNothingHappened().files, place.Files()), "");
  }
};

TEST_P(Kills, BeforeEachCallThatAltersAFolder) {
  if (verb().name != "score" && !IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1";
  ASSERT_TRUE(HadItsOutput());
  int kills = 0;
  for (const std::string kind : {"rename", "mkdir"}) {
    for (int n = 1; !HasFailure(); ++n) {
      const Workplace place(verb());
      const TemporaryFolder beside;
      const fs::path hit = beside.path() / "hit";
      const int code = place.Run("GAITCAM_FAIL=" + kind + ":" + std::to_string(n) +
                                 ":kill GAITCAM_FAIL_HIT=" + hit.string() + " LD_PRELOAD=" + FAIL_NTH);
      if (!fs::exists(hit)) {
        EXPECT_EQ(code, WhereNothingHappened().exit_code) << "nobody killed it";
        break;
      }
      SCOPED_TRACE("killed before " + kind + " " + std::to_string(n));
      ExpectTheSameAsEver(place);
      ++kills;
    }
  }
  EXPECT_GT(kills, 0);
  std::printf("%s: killed %d times before a call\n", verb().name.c_str(), kills);
}

TEST_P(Kills, AtRandomInstants) {
  if (verb().is_long && !IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1";
  ASSERT_TRUE(HadItsOutput());
  const char* wanted = std::getenv("GAITCAM_KILLS");
  const int most = !IsLongPart() ? 2 : wanted != nullptr ? std::atoi(wanted) : 100;
  RandomStream random(1, "kills of " + verb().name);
  int kills = 0, too_late = 0;
  while (kills < most && !HasFailure()) {
    const Workplace place(verb());
    std::string trace;
    for (int left = 1 + random.Index(3); left > 0; --left) {  // once or more before it is let go on
      const pid_t child = place.Start();
      const double delay_s = random.Uniform(0, WhereNothingHappened().seconds);
      std::this_thread::sleep_for(std::chrono::duration<double>(delay_s));
      kill(child, SIGKILL);
      const bool was_killed = Workplace::Wait(child) == 128 + SIGKILL;
      ++(was_killed ? kills : too_late);
      trace += " " + std::to_string(delay_s) + (was_killed ? " s" : " s (it had ended)");
    }
    SCOPED_TRACE("killed after" + trace);
    if (verb().name == "record" && fs::exists(place.path() / verb().output)) continue;  // it had ended: no second time
    ExpectTheSameAsEver(place);
  }
  std::printf("%s: killed %d times, %d times too late\n", verb().name.c_str(), kills, too_late);
}

TEST_P(Kills, TwiceAtOnce) {
  if (verb().name != "run" && !IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1";
  const Workplace place(verb());
  const pid_t one = place.Start(), other = place.Start();
  const std::multiset<int> codes = {Workplace::Wait(one), Workplace::Wait(other)};
  EXPECT_EQ(codes.count(WhereNothingHappened().exit_code) + codes.count(2), 2U) << "done, or refused in a line";
  EXPECT_GE(codes.count(WhereNothingHappened().exit_code), 1U);
  EXPECT_EQ(Changed(WhereNothingHappened().files, place.Files()), "");
}

TEST(ClockBack, TurnsTheClockBack) {
  const auto now_s = [](const std::string& variables) {
    return std::stoll(RunShell(variables + " date +%s", fs::temp_directory_path()).out);
  };
  EXPECT_LT(now_s(std::string("LD_PRELOAD=") + CLOCK_BACK), now_s("") - 3000);
}

// An hour at every look: what is found again in a cache was last used in the future.
TEST_P(Kills, WhileTheClockIsSetBack) {
  if (verb().is_long && !IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1";
  ASSERT_TRUE(HadItsOutput());
  const Workplace place(verb());
  const TemporaryFolder beside;
  const fs::path hit = beside.path() / "hit";
  EXPECT_EQ(place.Run("GAITCAM_CLOCK_HIT=" + hit.string() + " LD_PRELOAD=" + CLOCK_BACK),
            WhereNothingHappened().exit_code);
  EXPECT_EQ(Changed(WhereNothingHappened().files, place.Files()), "");
  EXPECT_TRUE(fs::exists(hit) || verb().name != "study") << "the cache looks at the clock";
}

INSTANTIATE_TEST_SUITE_P(Of, Kills, testing::Range(0, int(KilledVerbs().size())),
                         [](const auto& info) { return KilledVerbs()[size_t(info.param)].name; });

}  // namespace
}  // namespace gaitcam
