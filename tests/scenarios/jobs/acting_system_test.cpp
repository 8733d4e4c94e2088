// A job whose system asks the body for something: its walk is its own, simulated while it is tracked.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "algorithms/core/errors.h"
#include "scenarios/code/jobs/job.h"
#include "scenarios/code/runs/runner.h"
#include "scenarios/code/runs/tracked_system.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// Scans at its first frame, then takes a few steps.
constexpr const char* kActingScenario = R"(
robot: khr1hv_pan
scene: plain
duration_s: 0
path: {kind: straight, length_m: 0.1, settle_s: 0.6}
camera: {width_px: 208, height_px: 160, hfov_deg: 56.9, pitch_deg: 0, rate_hz: 5, exposure_ms: 5, antialias: 1}
scan: {speed_rad_s: 0.9}
system: topo_slam
)";

class ActingSystemTest : public testing::Test {
 protected:
  ActingSystemTest() {
    setenv("GAITCAM_DATA", TestData().c_str(), 1);
    std::ofstream(temporary_.path() / "s.yaml") << kActingScenario;
  }
  ResolvedScenario Scenario(const std::vector<std::string>& changes = {}) {
    return ReadScenario(temporary_.path() / "s.yaml", changes);
  }

  const TemporaryFolder temporary_;
};

TEST_F(ActingSystemTest, AJobOfItsOwnWalkScansAndTakesNothingFromTheCache) {
  JobOptions options;
  options.runs = temporary_.path() / "runs";
  options.cache.folder = temporary_.path() / "cache";
  const ResolvedScenario resolved = Scenario();
  ASSERT_TRUE(ActsOnBody(resolved.scenario));
  ASSERT_TRUE(RunJob(resolved, options));
  const std::optional<JobRecord> record = FindJob(options.runs, resolved);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->status, "finished");
  // 6.2 s of sweep and some five of standing and turning the head come to a walk of 4 s.
  EXPECT_GT(record->end_time_s, 13);
  EXPECT_NEAR(double(record->frames), record->end_time_s * 5, 2);
  EXPECT_EQ(record->failure, "");
  EXPECT_FALSE(fs::exists(options.cache.folder));
}

/// It comes to know the first place again only if it looked all around there, and was told of the steps since.
TEST_F(ActingSystemTest, ClosesTheLoopOfAWalkThereAndBack) {
  JobOptions options;
  options.runs = temporary_.path() / "runs";
  options.cache.folder = temporary_.path() / "cache";
  const ResolvedScenario resolved =
      Scenario({"scene=lab", "path.kind=there_and_back", "path.length_m=1.2", "camera.width_px=104",
                "camera.height_px=80", "camera.fixed_subframes=1"});
  ASSERT_TRUE(RunJob(resolved, options));
  const std::optional<JobRecord> record = FindJob(options.runs, resolved);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->failure, "");
  EXPECT_EQ(record->scores.at("place_nodes"), 2);
  EXPECT_EQ(record->scores.at("loops_closed"), 1);
  EXPECT_EQ(record->scores.at("loops_false"), 0);
  // 0.08 to 0.28 m over five seeds: on its way back it knows the place before it stands on it.
  EXPECT_LT(record->scores.at("loop_distance_max_m"), 0.35);
}

TEST_F(ActingSystemTest, IsRefusedARobotThatCannotLookAllAround) {
  EXPECT_NO_THROW(CheckPlan(Scenario()));
  EXPECT_THROW(CheckPlan(Scenario({"robot=khr1hv", "gait.foot_spacing_m=0.06"})), BadOption) << "its feet would touch";
  EXPECT_NO_THROW(CheckPlan(Scenario({"robot=khr1hv", "gait.foot_spacing_m=0.06", "system=orb_vo"})));
}

TEST_F(ActingSystemTest, ScanKeysAreReadAndLeftOutWhereTheyAreNotGiven) {
  EXPECT_EQ(SimulationOptionsOf(Scenario()).scan.speed_rad_s, 0.9);
  EXPECT_THROW(Scenario({"scan.speed_rad_s=99"}), BadInput);
  ResolvedScenario plain = Scenario();
  plain.scenario.scan.reset();
  EXPECT_EQ(plain.ToYaml().find("\nscan:"), std::string::npos);  // as before there were scans: hashes hold
  EXPECT_NE(Scenario().ToYaml().find("\nscan:"), std::string::npos);
}

}  // namespace
}  // namespace gaitcam
