// Depth cameras and odometry as they are, recorded: a system gets the same from the folder as from the walk.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/io/dataset_reader.h"
#include "scenarios/code/runs/runner.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kSensors = {"camera.depth=true", "camera.depth_model=structured_light",
                                           "sensors.odometry={rate_hz: 40}", "duration_s=1"};

class SensorRecording : public testing::TestWithParam<const char*> {
 protected:
  DatasetFolders Record(const std::string& format) const {
    std::vector<std::string> changes = kSensors;
    changes.push_back(std::string("robot=") + GetParam());
    return RecordTinyWalk(temporary_.path(), format, changes);
  }
  const TemporaryFolder temporary_;
};

INSTANTIATE_TEST_SUITE_P(Robot, SensorRecording, testing::Values("khr1hv", "omni_base"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(SensorRecording, GivesTheReadingsAndTheDataSheetsOfTheWalk) {
  const DatasetFolders folders = Record("euroc");
  const ResolvedScenario resolved = ReadScenario(folders.truth / "scenario.yaml", {});
  Simulation walk(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), resolved.scenario.seed);
  DatasetReader reader(folders.sensors);
  const OdometryCalibration &told = reader.calibration().odometry, &known = walk.calibration().odometry;
  EXPECT_EQ(told.rate_hz, 40);
  EXPECT_EQ(told.X_BC.translation, known.X_BC.translation);
  EXPECT_EQ(told.X_BC.rotation.coeffs(), known.X_BC.rotation.coeffs());
  EXPECT_NEAR(told.X_BC.translation.z(), walk.calibration().standing->height_m, 1e-12);
  EXPECT_EQ(told.heading_per_sqrt_rad, known.heading_per_sqrt_rad);
  EXPECT_EQ(reader.calibration().depth.sigma_per_m, walk.calibration().depth.sigma_per_m);
  size_t samples = 0;
  while (const std::optional<Observation> read = reader.Next()) {
    const std::optional<SimulatedFrame> frame = walk.Next();
    ASSERT_TRUE(frame);
    const Observation& seen = frame->observation;
    EXPECT_EQ(cv::norm(read->depth->pixels, seen.depth->pixels, cv::NORM_INF), 0);
    EXPECT_GT(cv::norm(seen.depth->pixels, frame->truth.depth, cv::NORM_INF), 0);
    ASSERT_EQ(read->odometry.size(), seen.odometry.size());
    for (size_t i = 0; i < seen.odometry.size(); ++i) {
      EXPECT_EQ(read->odometry[i].stamp_ns, seen.odometry[i].stamp_ns);
      EXPECT_EQ(read->odometry[i].position, seen.odometry[i].position);
      EXPECT_EQ(read->odometry[i].heading, seen.odometry[i].heading);
      EXPECT_LE(read->odometry[i].stamp_ns, seen.stamp_ns + 5'000'000) << "the shutter closes 5 ms after the middle";
    }
    samples += seen.odometry.size();
  }
  EXPECT_NEAR(double(samples), 0.91 * 40, 2) << "the last of ten frames ends after 0.91 s";
}

TEST_P(SensorRecording, IsValidAndWhatIsDamagedIsRefusedInItsLine) {
  const DatasetFolders folders = Record("tum");
  const ProgramResult valid = RunProgram("validate walk", temporary_.path());
  EXPECT_EQ(valid.exit_code, 0) << valid.out << valid.err;
  std::string table = ReadText(folders.sensors / "odometry.csv");
  table.replace(table.rfind(','), std::string::npos, ",north\n");
  temporary_.Write("walk/odometry.csv", table);
  const ProgramResult track = RunProgram("track walk --system mobif_vo --out tracked.txt", temporary_.path());
  EXPECT_EQ(track.exit_code, 2) << track.out;
  EXPECT_THAT(track.err, AllOf(HasSubstr("odometry.csv:"), HasSubstr("\"north\""), HasSubstr("heading in rad")));
  const std::string said = track.err.substr(track.err.find("gaitcam: "));  // beside how far it had come
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << track.err;
  const ProgramResult invalid = RunProgram("validate walk", temporary_.path());
  EXPECT_NE(invalid.exit_code, 0);
  EXPECT_THAT(invalid.out + invalid.err, AllOf(HasSubstr("odometry.csv:"), HasSubstr("the body's heading")));
}

}  // namespace
}  // namespace gaitcam
