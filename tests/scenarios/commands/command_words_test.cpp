// The words of the command line: help, lists, slips, completion, the manual page, colours.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CommandWordsTest : public testing::Test {
 protected:
  ProgramResult Run(const std::string& words) const { return RunProgram(words, temporary_.path()); }
  /// What the program says on a terminal. @param before of the call, assignments of variables.
  std::string OnTerminal(const std::string& words, const std::string& before = "") const {
    const std::string call = before + "GAITCAM_DATA=" + TestData().string() + " TERM=xterm " + Program() + " " + words;
    return RunShell("env -u NO_COLOR script -qec '" + call + "' /dev/null </dev/null", temporary_.path()).out;
  }
  /// One line on standard error, exit 2, nothing on standard output.
  void ExpectRefusal(const std::string& words, const std::string& line) const {
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 2) << words;
    EXPECT_EQ(result.err, "gaitcam: " + line + "\n") << words;
    EXPECT_EQ(result.out, "") << words;
  }

  const TemporaryFolder temporary_;
};

TEST_F(CommandWordsTest, HelpAndListFitAScreen) {
  for (const char* words : {"--help", "list", "list systems", "list scenarios", "help check"}) {
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::istringstream stream(result.out);
    int lines = 0;
    for (std::string line; std::getline(stream, line); ++lines) EXPECT_LE(line.size(), 100u) << words << ": " << line;
    EXPECT_GT(lines, 5) << words;
    EXPECT_LE(lines, 50) << words;
  }
}

TEST_F(CommandWordsTest, HelpOfAVerbIsWhatTheVerbSaysOfItself) {
  for (const std::string verb : {"run", "check", "list"}) EXPECT_EQ(Run("help " + verb).out, Run(verb + " --help").out);
  EXPECT_EQ(Run("help").out, Run("--help").out);
  EXPECT_THAT(Run("help run").out, HasSubstr("--seed"));
  ExpectRefusal("help rnu", "rnu: no such verb; did you mean run?");
}

TEST_F(CommandWordsTest, AListTellsMoreOfOneThing) {
  EXPECT_THAT(Run("list").out, AllOf(HasSubstr("khr1hv"), HasSubstr("lab "), HasSubstr("mobif_vo"),
                                     HasSubstr("quickstart"), Not(HasSubstr("a number from"))));
  EXPECT_THAT(Run("list systems mobif_vo").out, AllOf(HasSubstr("ratio = "), HasSubstr("a number from")));
  EXPECT_THAT(Run("list robots khr1hv").out, AllOf(HasSubstr("brisk"), HasSubstr("step_length_m")));
  EXPECT_THAT(Run("list scenes lab").out, HasSubstr("models/scenes/lab.yaml"));
  EXPECT_THAT(Run("list scenarios quickstart").out, HasSubstr("scenarios/quickstart.yaml"));
  ExpectRefusal("list sytems", "list: there is no kind \"sytems\"; did you mean systems?");
  ExpectRefusal("list robots khr1v", "list: there is no robot \"khr1v\"; did you mean khr1hv?");
  const nlohmann::json all = nlohmann::json::parse(Run("list --json").out);
  EXPECT_EQ(all["systems"], nlohmann::json::parse(Run("list systems --json").out));
  EXPECT_EQ(all["robots"]["khr1hv"], nlohmann::json::parse(Run("list robots khr1hv --json").out));
}

TEST_F(CommandWordsTest, ASlipIsAnsweredInOneLineWithTheNearestWord) {
  ExpectRefusal("rnu", "rnu: no such verb; did you mean run?");
  ExpectRefusal("-q chekc smoke", "chekc: no such verb; did you mean check?");
  ExpectRefusal("somersault", "somersault: no such verb; see gaitcam --help");
  ExpectRefusal("run quickstart --sed 7", "run: there is no option --sed; did you mean --seed?");
  ExpectRefusal("run", "scenario is required; see gaitcam help run");
  ExpectRefusal("doctor now", "doctor: now is a word too many; see gaitcam help doctor");
  ExpectRefusal("run quikstart", "quikstart: neither a file nor the name of a shipped one; did you mean quickstart?");
}

TEST_F(CommandWordsTest, ShippedFilesAreNamedByNameOrPathFromAnyFolder) {
  for (const char* words : {"validate quickstart", "validate scenarios/quickstart.yaml", "validate blur",
                            "validate scenarios/studies/exposure.yaml"}) {
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  temporary_.Write("quickstart", "sytem: sift_vo\n");  // a file of the user's goes first
  EXPECT_THAT(Run("validate quickstart").err, HasSubstr("quickstart:1:1: sytem: unknown key"));
}

TEST_F(CommandWordsTest, CompletionKnowsVerbsOptionsAndNames) {
  EXPECT_EQ(Run("complete re").out, "record\n");
  EXPECT_EQ(Run("complete run --s").out, "--seed\n--set\n--system\n");
  EXPECT_EQ(Run("complete run quickst").out, "quickstart\n");
  EXPECT_EQ(Run("complete run quickstart --system sift_").out, "sift_vo\n");
  EXPECT_EQ(Run("complete record quickstart --format tu").out, "tum\n");
  EXPECT_EQ(Run("complete check smo").out, "smoke\n");
  EXPECT_EQ(Run("complete list ro").out, "robots\n");
  EXPECT_EQ(Run("complete list robots nim").out, "nimbro\n");
  EXPECT_EQ(Run("complete schema su").out, "suite\n");
  EXPECT_EQ(Run("complete track datasets/").out, "");
  EXPECT_THAT(Run("complete ''").out, AllOf(HasSubstr("run\n"), HasSubstr("help\n"), Not(HasSubstr("work\n"))));
}

TEST_F(CommandWordsTest, TheManualPageHasEveryVerbAndOffendsNoFormatter) {
  const ProgramResult page = Run("help --man");
  EXPECT_EQ(page.exit_code, 0);
  EXPECT_THAT(page.out, AllOf(HasSubstr(".TH GAITCAM 1"), HasSubstr(".SS gaitcam run scenario"),
                              HasSubstr("\\fB\\-\\-seed\\fR"), Not(HasSubstr("gaitcam work"))));
  if (RunShell("command -v groff", temporary_.path()).exit_code != 0) GTEST_SKIP() << "no groff on this machine";
  temporary_.Write("gaitcam.1", page.out);
  const ProgramResult formatted = RunShell("groff -man -Tascii -ww -z gaitcam.1", temporary_.path());
  EXPECT_EQ(formatted.err, "");
}

TEST_F(CommandWordsTest, ColoursAreForTerminalsOnlyAndNotWithNoColor) {
  EXPECT_THAT(OnTerminal("list"), HasSubstr("\033[1mRobots\033[0m"));
  EXPECT_THAT(OnTerminal("rnu"), HasSubstr("\033[31mgaitcam:\033[0m rnu"));
  for (const char* words : {"list", "rnu"}) {
    EXPECT_THAT(OnTerminal(words, "NO_COLOR=1 "), Not(HasSubstr("\033")));
    const ProgramResult piped = Run(words);
    EXPECT_THAT(piped.out + piped.err, Not(HasSubstr("\033")));
  }
}

}  // namespace
}  // namespace gaitcam
