// A project of somebody else's that says find_package(gaitcam) in a folder where nothing else is.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenarios/package/build_folder.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kProject = R"(
cmake_minimum_required(VERSION 3.25)
project(somebody_elses LANGUAGES CXX)
find_package(gaitcam 0.1 REQUIRED)
if(TARGET gaitcam::sim OR TARGET mujoco)
  message(FATAL_ERROR "a SLAM system needs no simulator")
endif()
add_library(my_slam MODULE my_slam.cpp)
target_link_libraries(my_slam PRIVATE gaitcam::slam)
target_link_options(my_slam PRIVATE -Wl,--no-undefined)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(my_slam PRIVATE -mavx)
endif()
add_subdirectory(example)

find_package(gaitcam 0.1 REQUIRED COMPONENTS sim)
add_executable(my_gaitcam main.cpp)
target_link_libraries(my_gaitcam PRIVATE gaitcam::scenarios_commands)
)";

constexpr const char* kSystem = R"(
#include "algorithms/slam/system.h"

// Stands still, and says so in the types that cross the border.
struct MySlam : gaitcam::System {
  gaitcam::FrameEstimate Track(const gaitcam::Observation& observation) override {
    gaitcam::FrameEstimate estimate;
    estimate.stamp_ns = observation.stamp_ns;
    estimate.status = gaitcam::TrackingStatus::kTracking;
    estimate.pose = gaitcam::Pose();
    return estimate;
  }
};
static_assert(alignof(Eigen::Matrix4d) == 16, "matrices lie as in the program, whatever the processor");

extern "C" gaitcam::System* Make() { return gaitcam::ListSystems().empty() ? nullptr : new MySlam; }
)";

constexpr const char* kMain = R"(
#include "scenarios/code/commands/command_line.h"

int main(int argc, char** argv) { return gaitcam::CommandLine(argc, argv); }
)";

TEST(FindPackage, BuildsASystemAndAProgramAgainstAnInstallation) {
  if (!fs::exists(kBuild / "cmake_install.cmake")) GTEST_SKIP() << "the build folder is not here";
  const TemporaryFolder temporary;
  temporary.Write("project/CMakeLists.txt", kProject);
  temporary.Write("project/my_slam.cpp", kSystem);
  fs::copy(TestData() / "scenarios/examples/plugin", temporary.path() / "project/example");
  temporary.Write("project/main.cpp", kMain);
  const auto shell = [&](const std::string& command) {
    const ProgramResult result = RunShell(command, temporary.path());
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.out << result.err;
    return result.out;
  };
  shell("cmake --install " + kBuild.string() + " --prefix $PWD/staging --component dev");
  shell("mv staging elsewhere");  // an installation may be moved
  shell("cmake -S project -B build -G Ninja -D CMAKE_PREFIX_PATH=$PWD/elsewhere");
  shell("cmake --build build");
  EXPECT_TRUE(fs::exists(temporary.path() / "build/libmy_slam.so"));
  EXPECT_THAT(shell("GAITCAM_DATA=" + TestData().string() + " build/my_gaitcam list scenes"), HasSubstr("lab"));
}

}  // namespace
}  // namespace gaitcam
