// Each system call that a program makes fails once, the first, the second, ... until none is left. What must hold
// whichever it is: the program ends by itself with one of its exit codes and says why in one line; what it was to
// write is there whole, or is not there at all; what had been there before stays as it was.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/faults/inputs.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

struct Verb {
  std::string name;
  std::string arguments;
  std::string replaced;  ///< A file that is there before, in whose place it writes another; empty: none.
  bool is_long = false;
};

const std::vector<Verb>& Verbs() {
  static const std::vector<Verb> verbs = {
      {"list", "list scenes", "", false},
      {"schema", "schema scenario", "", false},
      {"validate", "validate walk.yaml", "", false},
      {"score", "-q score estimate.txt truth.txt --out scores.json", "scores.json", false},
      {"record", "-q record walk.yaml --out recorded", "", true},
      {"run", "-q run walk.yaml --out done", "", true},
  };
  return verbs;
}

class InjectedFaults : public testing::TestWithParam<std::tuple<int, std::string>> {
 protected:
  static const Verb& verb() { return Verbs()[size_t(std::get<0>(GetParam()))]; }

  /// @param said on standard output, where all goes well
  /// @returns whether there was such a call.
  static bool Try(const std::string& plan, const std::map<std::string, std::string>& wanted, const std::string& said) {
    const TemporaryFolder temporary;
    WriteInputs(temporary.path());
    if (!verb().replaced.empty()) std::ofstream(temporary.path() / verb().replaced) << "old";
    const std::map<std::string, std::string> before = FilesBelow(temporary.path());
    const TemporaryFolder beside;
    const fs::path hit = beside.path() / "hit";
    const ProgramResult result =
        RunShell("GAITCAM_DATA=" + TestData().string() + " GAITCAM_FAIL=" + plan + " GAITCAM_FAIL_HIT=" + hit.string() +
                     " LD_PRELOAD=" + FAIL_NTH + " " + Program() + " " + verb().arguments,
                 temporary.path());
    SCOPED_TRACE(verb().name + ", " + plan + ": exit " + std::to_string(result.exit_code) + ", " + result.err);
    const bool had_such_a_call = fs::exists(hit);
    if (result.exit_code == 0 || !had_such_a_call) {
      EXPECT_EQ(result.exit_code, 0) << "no call failed";
      EXPECT_EQ(result.out, said) << "it says that all went well, and printed something else";
      EXPECT_EQ(Changed(wanted, WhatStays(temporary.path())), "")
          << "it says that all went well, and wrote something else";
      return had_such_a_call;
    }
    EXPECT_THAT(result.exit_code, testing::AnyOf(2, 4));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1);
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("internal")));
    EXPECT_EQ(Changed(before, FilesBelow(temporary.path())), "")
        << "what was there stays, and nothing half-written is added";
    return true;
  }
};

TEST_P(InjectedFaults, EndInOneLineAndLeaveNothingHalfWritten) {
  if (verb().is_long && !IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1";
  const TemporaryFolder temporary;
  WriteInputs(temporary.path());
  const ProgramResult undisturbed = RunProgram(verb().arguments, temporary.path());
  ASSERT_EQ(undisturbed.exit_code, 0);
  const std::map<std::string, std::string> wanted = WhatStays(temporary.path());
  const std::string& kind = std::get<1>(GetParam());
  constexpr int kMost = 20000;
  int n = 1;
  while (n < kMost && !HasFailure() && Try(kind + ":" + std::to_string(n), wanted, undisturbed.out)) ++n;
  if (kind == "write") {
    EXPECT_GT(n, 1) << "each verb prints or writes something";
  }
  RecordProperty("calls", n - 1);
  std::printf("%s: %d calls of %s failed one after the other\n", verb().name.c_str(), n - 1, kind.c_str());
  const bool renders = verb().is_long;  // where nothing at all can be mapped, the driver's compiler aborts
  if (n > 1 && !(renders && kind == "mmap")) Try(kind + ":1:all", wanted, undisturbed.out);
}

INSTANTIATE_TEST_SUITE_P(Verbs, InjectedFaults,
                         testing::Combine(testing::Range(0, int(Verbs().size())),
                                          testing::Values("open", "read", "write", "rename", "mkdir", "mmap")),
                         [](const auto& info) {
                           return Verbs()[size_t(std::get<0>(info.param))].name + "_" + std::get<1>(info.param);
                         });

}  // namespace
}  // namespace gaitcam
