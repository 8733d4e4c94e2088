/// The one interface of a SLAM system, and the registry of names.

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/estimate.h"
#include "algorithms/core/floor_picture.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/place_graph.h"

namespace gaitcam {

/// A number (a flag is 0 or 1) or a text.
struct SettingValue : std::variant<double, std::string> {
  SettingValue(double number = 0) : variant(number) {}  // NOLINT: what a user writes down is a setting's value
  template <class Number, class = std::enable_if_t<std::is_arithmetic_v<Number>>>
  SettingValue(Number number) : variant(double(number)) {}
  SettingValue(std::string text) : variant(std::move(text)) {}
  SettingValue(const char* text) : variant(std::string(text)) {}

  const double* number() const { return std::get_if<double>(this); }
  const std::string* text() const { return std::get_if<std::string>(this); }
  /// As a message or a list shows it; texts in quotation marks.
  std::string ToText() const;
};

/// What a user may set for a system by name (`system: {name: mobif_vo, feature: akaze, ratio: 0.8}`).
using SystemSettings = std::map<std::string, SettingValue>;

/// What a system is built from. No truth, no initial pose, no scale: those are the scorer's business.
struct SystemSetup {
  Calibration calibration;
  uint64_t seed = 1;        ///< All randomness of the system derives from it.
  SystemSettings settings;  ///< Checked by the system: unknown names and bad values throw BadOption.
};

/// What a system asks of the body that carries its camera.
enum class BodyRequest {
  kGoOn,  ///< Follow the path.
  kScan,  ///< Stop, stand, look all around, then go on; Observation::scan is set meanwhile.
};

/// A SLAM system or odometry: frames in, poses out, in order. Deterministic: the same setup and observations give the
/// same bits, whatever the machine's load.
class System {
 public:
  virtual ~System() = default;
  /// Answers one frame; observations come with increasing stamps.
  virtual FrameEstimate Track(const Observation& observation) = 0;
  /// Called once after the last frame: a system that refined its past (loop closure) returns its final word on all
  /// frames; an odometry returns nothing.
  virtual std::vector<FrameEstimate> Finish() { return {}; }
  /// After Finish(): the floor as it was mapped, in the plane z = 0 of the system's world; nothing if it maps none.
  virtual std::optional<FloorPicture> Floor() const { return std::nullopt; }
  /// After Finish(): the topological map; nothing if it makes none.
  virtual std::optional<PlaceGraph> Places() const { return std::nullopt; }
  /// Whether it may ask anything of the body. Then the walk waits for its answer to each frame, and recorded walks are
  /// not for it.
  virtual bool Acts() const { return false; }
  /// After each Track(): what the body is asked to do. The same request again, while it is being served, changes
  /// nothing.
  virtual BodyRequest Request() const { return BodyRequest::kGoOn; }
  /// After Finish(): why it stopped working, in one line; empty if it did not. For systems that are not ours: a crash
  /// of theirs is a result, not an error.
  virtual std::string Failure() const { return {}; }
};

struct SystemInfo {
  std::string name;
  std::string description;  ///< One line for `gaitcam list`.
  SystemSettings defaults;  ///< Its settings and their default values.
};

/// Names of all systems, sorted.
std::vector<SystemInfo> ListSystems();

/// @throws BadInput naming the unknown system and the nearest known one, or an unknown setting; BadOption for a value.
std::unique_ptr<System> MakeSystem(const std::string& name, const SystemSetup& setup);

}  // namespace gaitcam
