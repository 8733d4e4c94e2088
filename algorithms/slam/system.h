/// The interface of a SLAM system, what is known of each system without building it, and the registry of names.

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/body_command.h"
#include "algorithms/core/camera.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/field_list.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/option_value.h"
#include "algorithms/core/route_map.h"

namespace gaitcam {

/// What a user may set for a system by name (`system: {name: mobif_vo, feature: akaze, ratio: 0.8}`): numbers,
/// flags and texts; a name within a group has a dot (`matching.ratio`).
using SystemSettings = std::map<std::string, OptionValue>;

/// What a system is built from. No truth, no initial pose, no scale: those are the scorer's business.
struct SystemSetup {
  Calibration calibration;
  uint64_t seed = 1;        ///< All randomness of the system derives from it.
  SystemSettings settings;  ///< Checked by the system: unknown names and bad values throw BadOption.
  std::shared_ptr<const RouteMap> map = nullptr;  ///< What it is to know beforehand, if SystemInfo::map says so.
};

/// A SLAM system or odometry: frames in, poses out, in order. Deterministic: the same setup and observations give the
/// same bits, whatever the machine's load.
class System {
 public:
  virtual ~System() = default;
  /// Answers one frame; observations come with increasing stamps.
  virtual FrameEstimate Track(const Observation& observation) = 0;
  /// Called once after the last frame: poses that were refined since they were given (loop closure, smoothing), maps,
  /// and why it stopped working, if it did. For an external system a crash is a result, not an error.
  virtual FinalEstimate Finish() { return {}; }
  /// After each Track(), if SystemInfo::acts: what the body is asked to do from now on.
  virtual BodyCommand Command() const { return FollowPath(); }
};

/// What a system may need beyond one camera and its intrinsics.
enum class SensorNeed {
  kStereo,          ///< Observation::right.
  kDepth,           ///< Observation::depth.
  kImu,             ///< Observation::imu.
  kJoints,          ///< Observation::joints.
  kStandingCamera,  ///< Calibration::standing.
  kOdometry,        ///< Observation::odometry.
};

constexpr auto WordsOf(SensorNeed) {
  return std::array{EnumWord{SensorNeed::kStereo, "stereo"},
                    EnumWord{SensorNeed::kDepth, "depth"},
                    EnumWord{SensorNeed::kImu, "imu"},
                    EnumWord{SensorNeed::kJoints, "joints"},
                    EnumWord{SensorNeed::kStandingCamera, "standing_camera"},
                    EnumWord{SensorNeed::kOdometry, "odometry"}};
}
inline std::string ToString(SensorNeed need) { return std::string(ToWord(need)); }

/// Whether a system starts from a map that was learned before.
enum class MapUse {
  kNone,
  kTaken,   ///< It goes on where earlier sessions ended, if it is given one.
  kNeeded,  ///< It cannot work without one.
};

/// What is known of a system without building one.
struct SystemInfo {
  std::string name;
  std::string description;         ///< One line.
  std::vector<FieldInfo> options;  ///< In the order of their description.
  std::vector<SensorNeed> needs;   ///< Without these it cannot work; what it uses if it is there is not listed.
  bool acts = false;               ///< It gives commands to the body: the walk waits for its answer to each frame, and
                                   ///< recorded walks are not for it.
  MapUse map = MapUse::kNone;

  SystemSettings Defaults() const;
};

/// All systems, sorted by name.
const std::vector<SystemInfo>& ListSystems();

/// @throws BadInput naming the unknown system and the nearest known one.
const SystemInfo& InfoOfSystem(const std::string& name);

/// Those of `needs` that a rig does not have. @param has_joints whether joints are recorded: no calibration tells.
std::vector<SensorNeed> MissingSensors(const std::vector<SensorNeed>& needs, const Calibration& calibration,
                                       bool has_joints);

/// @throws BadInput naming the unknown system and the nearest known one, or an unknown setting; BadOption for a value.
std::unique_ptr<System> MakeSystem(const std::string& name, const SystemSetup& setup);

}  // namespace gaitcam
