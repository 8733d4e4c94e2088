// The Debian packages, made of what was built, installed in an empty root and used by somebody without rights there.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/scenarios/package/build_folder.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kNobody = "64999";  // a user without a name, whose files nobody else makes

/// A short walk of the quick start: one second in few pixels.
constexpr const char* kShort =
    "--set duration_s=1 --set path.settle_s=0.2 --set camera.width_px=160 --set camera.height_px=120 "
    "--set camera.rate_hz=10 --set camera.fixed_subframes=2 --set score.min_coverage_ratio=0 --set score.min_pairs=3 "
    "--set system=floor_slam";

class PackageTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kBuild / "CPackConfig.cmake")) GTEST_SKIP() << "the build folder is not here";
    if (RunShell("command -v cpack dpkg-shlibdeps dpkg-deb file", folder()).exit_code != 0)
      GTEST_SKIP() << "no cpack, dpkg-dev or file on this machine";
    fs::permissions(folder(), fs::perms(0755));
    fs::create_directories(root() / "var/lib/dpkg/info");
    fs::create_directories(root() / "var/lib/dpkg/updates");
    std::ofstream(root() / "var/lib/dpkg/status");
  }
  const fs::path& folder() const { return temporary_.path(); }
  fs::path root() const { return folder() / "root"; }

  ProgramResult Shell(const std::string& command) const {
    const ProgramResult result = RunShell(command, folder());
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.out << result.err;
    return result;
  }
  /// As a user's shell would, in a folder of the user's own that is also the home.
  ProgramResult Gaitcam(const std::string& words) const {
    const std::string other_user =
        AsRoot() ? "setpriv --clear-groups --regid=" + kNobody + " --reuid=" + kNobody + " " : "";
    return RunShell("cd home && " + other_user + "env -u GAITCAM_DATA -u GAITCAM_PROGRAM -u XDG_CACHE_HOME HOME=$PWD " +
                        (root() / "usr/bin/gaitcam").string() + " " + words,
                    folder());
  }

  void MakePackages() const { Shell("cpack --config " + (kBuild / "CPackConfig.cmake").string() + " -B packages"); }
  std::string DependenciesOf(const std::string& package) const {
    return Shell("dpkg-deb --field packages/" + package + "_*.deb Depends").out;
  }
  /// With dpkg's own checks, which only root can ask for, but for dependencies: they are not in the empty root.
  void Install(const std::string& package) const {
    const std::string file = "packages/" + package + "_*.deb";
    Shell(AsRoot() ? "dpkg --root=root --log=/dev/null --force-depends --install " + file
                   : "dpkg-deb --extract " + file + " root");
  }
  void MakeHome() const {
    fs::create_directories(folder() / "home");
    if (AsRoot()) Shell("chown " + kNobody + " home");
    Shell("touch installed; sleep 0.01");
  }
  void ExpectNothingWrittenOutsideHome() const {
    EXPECT_EQ(Shell("find root -newer installed").out, "") << "something was written into the installation";
    if (!AsRoot()) return;
    const std::string find = "find / -xdev -maxdepth 3 -uid " + kNobody + " -newer installed";
    EXPECT_EQ(Shell(find + " -not -path '/proc/*' -not -path '" + folder().string() + "*' 2>/dev/null; true").out, "");
  }
  static bool AsRoot() { return geteuid() == 0; }

  const TemporaryFolder temporary_;
};

TEST_F(PackageTest, InstalledInAnEmptyRootItRunsForAnybodyAndWritesNothingElsewhere) {
  MakePackages();
  for (const char* name :
       {"libmujoco", "libopencv-core", "libyaml-cpp", "libegl-mesa0", "libgl1-mesa-dri", "libjs-chart.js"})
    EXPECT_THAT(DependenciesOf("gaitcam"), HasSubstr(name));
  for (const char* name : {"libeigen3-dev", "libopencv-dev", "libceres-dev"})
    EXPECT_THAT(DependenciesOf("gaitcam-dev"), HasSubstr(name));

  Install("gaitcam");
  Install("gaitcam-dev");
  for (const char* name :
       {"bin/gaitcam", "libexec/gaitcam/gaitcam", "libexec/gaitcam/gaitcam_experiments", "lib/gaitcam",
        "lib/cmake/gaitcam/gaitcamConfig.cmake", "include/gaitcam/algorithms/slam/system.h",
        "share/gaitcam/models/robots/khr1hv/khr1hv.urdf", "share/gaitcam/models/scenes/lab.yaml",
        "share/gaitcam/scenarios/quickstart.yaml", "share/gaitcam/scenarios/suites/smoke.yaml",
        "share/gaitcam/results/baselines/smoke.json", "share/gaitcam/schema/scenario.schema.json",
        "share/man/man1/gaitcam.1.gz", "share/bash-completion/completions/gaitcam"}) {
    EXPECT_TRUE(fs::exists(root() / "usr" / name)) << name;
  }

  MakeHome();
  const ProgramResult run = Gaitcam(std::string("run quickstart ") + kShort);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(folder() / "home/runs/quickstart-floor_slam-seed1/report.html")) << run.out << run.err;
  const std::string scenario = (root() / "usr/share/gaitcam/scenarios/quickstart.yaml").string();
  const ProgramResult record = Gaitcam("record " + scenario + " " + kShort);
  EXPECT_EQ(record.exit_code, 0) << record.err;
  EXPECT_TRUE(fs::exists(folder() / "home/datasets/quickstart-seed1"));
  const ProgramResult update = Gaitcam("check smoke --update");
  EXPECT_EQ(update.exit_code, 2);
  EXPECT_THAT(update.err, HasSubstr("belongs to the installation"));
  EXPECT_EQ(Gaitcam("doctor").exit_code, 0);
  ExpectNothingWrittenOutsideHome();
}

}  // namespace
}  // namespace gaitcam
