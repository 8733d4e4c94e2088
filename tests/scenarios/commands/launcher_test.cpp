// The script that people type: what it says on a machine that lacks something, and that a second call builds nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kLauncher = fs::path(GAITCAM_SOURCE_DIR) / "gaitcam";

int Lines(const std::string& text) { return int(std::count(text.begin(), text.end(), '\n')); }

class LauncherTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kLauncher)) GTEST_SKIP() << "the sources are not here: these are installed tests";
  }
  fs::path File(const std::string& name) const { return temporary_.path() / name; }
  ProgramResult Shell(const std::string& command) const { return RunShell(command, temporary_.path()); }

  /// A small project that the launcher takes for its own: the real launcher, CMake and ninja, but seconds to build.
  void MakeProject(const std::string& program) const {
    fs::create_directories(File("project/source"));
    fs::copy_file(kLauncher, File("project/gaitcam"));
    fs::copy_file(fs::path(GAITCAM_SOURCE_DIR) / "CMakePresets.json", File("project/CMakePresets.json"));
    std::ofstream(File("project/CMakeLists.txt")) << R"(
cmake_minimum_required(VERSION 3.25)
project(small LANGUAGES CXX)
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/source/*.cpp)
add_executable(gaitcam_program ${sources})
set_target_properties(gaitcam_program PROPERTIES OUTPUT_NAME gaitcam RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
)";
    std::ofstream(File("project/source/main.cpp")) << program;
  }

  const TemporaryFolder temporary_;
};

TEST_F(LauncherTest, AMachineWithoutAptIsToldInOneLine) {
  fs::create_directories(File("bin"));
  for (const char* tool : {"bash", "readlink", "dirname", "id", "grep"}) {
    fs::create_symlink(fs::path("/usr/bin") / tool, File("bin") / tool);
  }
  for (const char* words : {"run walk.yaml", "experiment --list", "test", "benchmark", "package"}) {
    const ProgramResult result = Shell("env -i PATH=" + File("bin").string() + " " + kLauncher.string() + " " + words);
    EXPECT_EQ(result.exit_code, 4) << result.err;
    EXPECT_EQ(Lines(result.err), 1) << result.err;
    EXPECT_THAT(result.err, HasSubstr("this machine has no apt"));
    EXPECT_EQ(result.out, "");
  }
}

TEST_F(LauncherTest, AQuestionIsNoReasonToBuild) {
  MakeProject("#include <cstdio>\nint main(int n, char** words) { std::puts(n > 1 ? words[1] : \"all verbs\"); }\n");
  const auto says_what_to_type = testing::AllOf(HasSubstr("./gaitcam run scenarios/quickstart.yaml"),
                                                HasSubstr("./gaitcam test"), HasSubstr("installs Debian packages"));
  for (const char* words : {"", "help", "-h", "--help", "run --help", "help run", "test --help", "experiment -h"}) {
    const ProgramResult result = Shell(std::string("project/gaitcam ") + words);
    EXPECT_EQ(result.exit_code, 0) << words;
    EXPECT_THAT(result.out, says_what_to_type) << words;
    EXPECT_EQ(result.err, "") << words;
    EXPECT_FALSE(fs::exists(File("project/build"))) << words;
  }
  EXPECT_EQ(Shell("project/gaitcam list").exit_code, 0);  // builds
  EXPECT_EQ(Shell("project/gaitcam").out, "all verbs\n");
  EXPECT_EQ(Shell("project/gaitcam --help").out, "--help\n") << "the program answers for itself";
  EXPECT_THAT(Shell("project/gaitcam test --help").out, says_what_to_type) << "tests are the launcher's";
  EXPECT_THAT(Shell("project/gaitcam experiment --help").out, says_what_to_type) << "a program that is not built yet";
}

TEST_F(LauncherTest, ASecondCallBuildsNothingAndSaysNothing) {
  MakeProject("#include <cstdio>\nint main(int n, char** words) { std::puts(n > 1 ? words[1] : \"\"); return 7; }\n");
  EXPECT_EQ(Shell("project/gaitcam complete li").exit_code, 0);
  EXPECT_FALSE(fs::exists(File("project/build"))) << "completion is no reason to build";
  const ProgramResult first = Shell("project/gaitcam list");
  EXPECT_EQ(first.exit_code, 7) << first.err;
  EXPECT_EQ(first.out, "list\n");
  EXPECT_THAT(first.err, HasSubstr("configuring (release)"));
  EXPECT_THAT(first.err, HasSubstr("building (release"));
  const ProgramResult second = Shell("project/gaitcam list");
  EXPECT_EQ(second.exit_code, 7);
  EXPECT_EQ(second.out, "list\n");
  EXPECT_EQ(second.err, "");
  const ProgramResult on_terminal = Shell("script -qec 'project/gaitcam list' /dev/null </dev/null");
  EXPECT_EQ(on_terminal.exit_code, 7);
  EXPECT_EQ(on_terminal.out, "list\r\n");
  std::ofstream(File("project/source/more.cpp")) << "int more() { return 1; }\n";  // a new file is noticed
  EXPECT_THAT(Shell("project/gaitcam list").err, HasSubstr("building (release"));
  EXPECT_EQ(Shell("project/gaitcam list").err, "");
}

TEST_F(LauncherTest, ABuildThatFailsIsExitCodeFourWithTheCompilersWords) {
  MakeProject("int main() { return missing_name; }\n");
  const ProgramResult result = Shell("project/gaitcam list");
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("missing_name"));
  EXPECT_THAT(result.err, HasSubstr("the build failed; the whole log: "));
}

TEST_F(LauncherTest, AnInstalledOneFindsProgramAndDataFromAnywhere) {
  for (const char* folder : {"prefix/bin", "prefix/libexec/gaitcam", "prefix/share", "elsewhere"}) {
    fs::create_directories(File(folder));
  }
  fs::copy_file(kLauncher, File("prefix/bin/gaitcam"));
  fs::create_symlink(Program(), File("prefix/libexec/gaitcam/gaitcam"));
  fs::create_symlink(TestData(), File("prefix/share/gaitcam"));
  const ProgramResult list = Shell("cd elsewhere && ../prefix/bin/gaitcam list");
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_THAT(list.out, HasSubstr("khr1hv"));
  const ProgramResult test = Shell("cd elsewhere && ../prefix/bin/gaitcam test");
  EXPECT_EQ(test.exit_code, 4);
  EXPECT_THAT(test.err, HasSubstr("has no tests"));
}

/// What a test program says of two tests.
constexpr const char* kTwoTests =
    "#!/bin/sh\n"
    "echo '[       OK ] Small.IsQuick (20 ms)'\n"
    "echo '[  FAILED  ] Small/Each.IsSlow/0, where GetParam() = 3 (3400 ms)'\n"
    "echo '[  FAILED  ] Small/Each.IsSlow/0, where GetParam() = 3'\n"
    "exit 1\n";

TEST_F(LauncherTest, TestsEndWithTheSlowestAndWithCtestsExitCode) {
  MakeProject("int main() { return 0; }\n");
  temporary_.Write("project/two.sh", kTwoTests);
  std::ofstream(File("project/CMakeLists.txt"), std::ios::app)
      << "enable_testing()\nadd_test(NAME room.Small COMMAND sh ${CMAKE_SOURCE_DIR}/two.sh)\n"
         "add_test(NAME house.sleep COMMAND sleep 0.3)\n";
  // A machine that has all that the real project's tests need.
  fs::permissions(temporary_.Write("bin/dpkg-query", "#!/bin/sh\necho installed\n"), fs::perms(0755));
  const std::string call = "PATH=$PWD/bin:$PATH project/gaitcam test";
  const ProgramResult all = Shell(call);
  EXPECT_EQ(all.exit_code, 8) << all.err;  // ctest's own, for tests that failed
  EXPECT_THAT(all.out, testing::ContainsRegex("The slowest tests:\n +3\\.40 s  room\\.Small/Each\\.IsSlow/0\n"
                                              " +0\\.[0-9]+ s  house\\.sleep\n +0\\.02 s  room\\.Small\\.IsQuick\n$"));
  const ProgramResult one = Shell(call + " -R sleep");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_THAT(one.out, testing::ContainsRegex("The slowest tests:\n +0\\.[0-9]+ s  house\\.sleep\n$"));
}

TEST_F(LauncherTest, InstalledTestsEndWithTheSlowestToo) {
  fs::create_directories(File("prefix/bin"));
  fs::copy_file(kLauncher, File("prefix/bin/gaitcam"));
  fs::permissions(temporary_.Write("prefix/libexec/gaitcam/tests/small_test", kTwoTests), fs::perms(0755));
  const ProgramResult test = Shell("prefix/bin/gaitcam test");
  EXPECT_EQ(test.exit_code, 1);
  EXPECT_THAT(test.err, HasSubstr("tests failed in small_test"));
  EXPECT_THAT(test.out,
              testing::EndsWith("The slowest tests:\n     3.40 s  Small/Each.IsSlow/0\n     0.02 s  Small.IsQuick\n"));
}

TEST_F(LauncherTest, OfThousandsOfTestsTwentyAreListedAndTheExitCodeIsKept) {
  fs::create_directories(File("prefix/bin"));
  fs::copy_file(kLauncher, File("prefix/bin/gaitcam"));
  const std::string tests =
      "#!/bin/sh\nfor i in $(seq 3000); do echo \"[       OK ] Suite.WithALongName$i ($i ms)\"; done\n";
  fs::permissions(temporary_.Write("prefix/libexec/gaitcam/tests/large_test", tests), fs::perms(0755));
  const ProgramResult test = Shell("prefix/bin/gaitcam test");
  EXPECT_EQ(test.exit_code, 0) << test.err;
  const size_t list = test.out.find("The slowest tests:\n");
  ASSERT_NE(list, std::string::npos);
  EXPECT_EQ(Lines(test.out.substr(list)), 21);
  EXPECT_THAT(test.out.substr(list), HasSubstr(":\n     3.00 s  Suite.WithALongName3000\n"));
}

TEST(MachineWithoutEgl, IsToldInOneLineAndNothingIsWritten) {
  const TemporaryFolder temporary;
  const fs::path vendors = temporary.path() / "no-vendors";
  fs::create_directories(vendors);
  std::ofstream(temporary.path() / "walk.yaml") << "duration_s: 1\n";
  const std::string call =
      "GAITCAM_DATA=" + TestData().string() + " __EGL_VENDOR_LIBRARY_DIRS=" + vendors.string() + " " + Program() + " ";
  for (const std::string verb : {"run", "record"}) {
    const ProgramResult result = RunShell(call + verb + " walk.yaml --out results/here", temporary.path());
    EXPECT_EQ(result.exit_code, 4) << result.err;
    EXPECT_EQ(Lines(result.err), 1) << result.err;
    EXPECT_THAT(result.err, HasSubstr("no EGL device"));
    EXPECT_FALSE(fs::exists(temporary.path() / "results"));
  }
  const ProgramResult doctor = RunShell(call + "doctor", temporary.path());
  EXPECT_EQ(doctor.exit_code, 4);
  EXPECT_THAT(doctor.out, HasSubstr("EGL            MISSING"));
  EXPECT_THAT(doctor.out, HasSubstr("EGL lists no device"));
}

}  // namespace
}  // namespace gaitcam
