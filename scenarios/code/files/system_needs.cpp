#include "scenarios/code/files/system_needs.h"

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// What is needed, what a scenario has to say, and what a dataset has to hold.
struct NeedText {
  const char* what;
  const char* scenario;
  const char* dataset;
};

NeedText TextOf(SensorNeed need) {
  switch (need) {
    case SensorNeed::kStereo:
      return {"a stereo camera", "camera.stereo.baseline_m to a distance above 0", "a right camera (right, X_LR)"};
    case SensorNeed::kDepth: return {"depth images", "camera.depth to true", "depth images (has_depth: true)"};
    case SensorNeed::kImu: return {"an IMU", "sensors.imu_rate_hz to a rate above 0", "an IMU (imu.rate_hz above 0)"};
    case SensorNeed::kJoints: return {"joint encoders", "robot to one that has joints", "joint readings (joints.csv)"};
    case SensorNeed::kOdometry:
      return {"the body's odometry", "sensors.odometry.rate_hz to a rate above 0",
              "odometry (odometry.csv, odometry.rate_hz above 0)"};
    case SensorNeed::kStandingCamera:
      return {"to know how the camera stands", "robot to one that stands", "how the camera stands (standing)"};
  }
  GAITCAM_ASSERT(false);
  return {};
}

std::string Joined(const std::string& list, const std::string& entry) {
  return list.empty() ? entry : list + " and " + entry;
}

}  // namespace

std::optional<std::string> LackInScenario(const SystemInfo& info, const Calibration& calibration) {
  std::string needs, keys;
  for (const SensorNeed need : MissingSensors(info.needs, calibration, true)) {
    needs = Joined(needs, TextOf(need).what);
    keys = Joined(keys, TextOf(need).scenario);
  }
  if (needs.empty()) return std::nullopt;
  return info.name + " needs " + needs + ", which this scenario does not give it; set " + keys;
}

std::optional<std::string> LackInDataset(const SystemInfo& info, const Calibration& calibration,
                                         const std::filesystem::path& sensors) {
  if (info.acts) {
    return sensors.string() + ": a recorded walk; " + info.name +
           " commands the robot, which can be done in a simulated one alone (gaitcam run)";
  }
  std::string needs, lacks;
  const bool has_joints = std::filesystem::exists(sensors / "joints.csv");
  for (const SensorNeed need : MissingSensors(info.needs, calibration, has_joints)) {
    needs = Joined(needs, TextOf(need).what);
    lacks = Joined(lacks, TextOf(need).dataset);
  }
  if (needs.empty()) return std::nullopt;
  return sensors.string() + ": " + info.name + " needs " + needs + "; this dataset, or its calibration.yaml, lacks " +
         lacks;
}

}  // namespace gaitcam
