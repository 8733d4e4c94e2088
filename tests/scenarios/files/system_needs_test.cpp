// What a system cannot work without is known before a walk begins, and told with the keys that would help.

#include "scenarios/code/files/system_needs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "algorithms/core/errors.h"
#include "algorithms/io/route_map_file.h"
#include "scenarios/code/files/scenario.h"
#include "sim/camera/camera_rig.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SystemInfo Needing(std::vector<SensorNeed> needs, bool acts = false) { return {"some_slam", "", {}, needs, acts}; }

Calibration Rig(const CameraOptions& options) { return CameraRig(options, 1).MakeCalibration(); }

TEST(SystemNeeds, AScenarioIsToldWhichKeysToSet) {
  CameraOptions camera;
  const SystemInfo info = Needing({SensorNeed::kStereo, SensorNeed::kDepth});
  const std::optional<std::string> lack = LackInScenario(info, Rig(camera));
  ASSERT_TRUE(lack);
  EXPECT_THAT(*lack, AllOf(HasSubstr("some_slam needs a stereo camera and depth images"),
                           HasSubstr("camera.stereo.baseline_m"), HasSubstr("camera.depth to true")));
  camera.stereo.baseline_m = 0.06;
  EXPECT_THAT(*LackInScenario(info, Rig(camera)), HasSubstr("needs depth images"));
  camera.depth = true;
  EXPECT_FALSE(LackInScenario(info, Rig(camera)));
}

TEST(SystemNeeds, ARigWithoutImuIsToldSo) {
  Calibration calibration = Rig({});
  EXPECT_THAT(*LackInScenario(Needing({SensorNeed::kImu}), calibration), HasSubstr("sensors.imu_rate_hz"));
  calibration.imu.rate_hz = 100;
  EXPECT_FALSE(LackInScenario(Needing({SensorNeed::kImu}), calibration));
}

TEST(SystemNeeds, ADatasetIsToldWhatItLacks) {
  const TemporaryFolder folder;
  const Calibration calibration = Rig({});
  EXPECT_FALSE(LackInDataset(Needing({}), calibration, folder.path()));
  EXPECT_THAT(*LackInDataset(Needing({SensorNeed::kJoints}), calibration, folder.path()), HasSubstr("joints.csv"));
  std::ofstream(folder.path() / "joints.csv") << "#\n";
  EXPECT_FALSE(LackInDataset(Needing({SensorNeed::kJoints}), calibration, folder.path()));
  EXPECT_THAT(*LackInDataset(InfoOfSystem("floor_slam"), calibration, folder.path()),
              AllOf(HasSubstr("floor_slam needs to know how the camera stands"), HasSubstr("(standing)")));
  EXPECT_THAT(*LackInDataset(Needing({}, true), calibration, folder.path()), HasSubstr("a recorded walk"));
}

/// Of the default camera, with one view.
void WriteSmallMap(const std::filesystem::path& file) {
  RouteMap map;
  map.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  map.feature = "surf";
  map.graph.nodes.emplace_back();
  map.views.emplace_back();
  map.views[0].keypoints.emplace_back(100.0F, 100.0F, 5.0F);
  map.views[0].descriptors = cv::Mat::ones(1, 64, CV_32FC1);
  map.views[0].depth_m = {1};
  WriteRouteMap(file, map);
}

TEST(SystemNeeds, EveryShippedSystemGetsWhatItNeedsFromAPlainScenario) {
  setenv("GAITCAM_DATA", TestData().c_str(), 1);
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "s.yaml") << "robot: khr1hv_pan\nscene: plain\ncamera: {pitch_deg: 0}\n";
  WriteSmallMap(folder.path() / "small.map");
  for (const SystemInfo& info : ListSystems()) {
    std::vector<std::string> assignments{"system=" + info.name};
    if (info.map == MapUse::kNeeded) {
      EXPECT_THROW(ReadScenario(folder.path() / "s.yaml", assignments), BadInput) << info.name << " without a map";
      assignments.push_back("map=" + (folder.path() / "small.map").string());
    }
    for (const auto& [need, assignment] : {std::pair(SensorNeed::kStereo, "camera.stereo.baseline_m=0.06"),
                                           std::pair(SensorNeed::kDepth, "camera.depth=true"),
                                           std::pair(SensorNeed::kOdometry, "sensors.odometry.rate_hz=50")}) {
      if (std::count(info.needs.begin(), info.needs.end(), need) == 0) continue;
      EXPECT_THROW(ReadScenario(folder.path() / "s.yaml", assignments), BadInput) << info.name << " with one plain eye";
      assignments.push_back(assignment);
    }
    EXPECT_NO_THROW(ReadScenario(folder.path() / "s.yaml", assignments)) << info.name;
  }
}

}  // namespace
}  // namespace gaitcam
