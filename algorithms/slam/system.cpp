#include "algorithms/slam/system.h"

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/odometry/frame_to_frame_vo.h"
#include "algorithms/odometry/mobif_vo_plus.h"
#include "algorithms/slam/floor_slam.h"
#include "algorithms/slam/settings.h"
#include "algorithms/slam/topo_slam.h"

namespace gaitcam {
namespace {

struct Entry {
  SystemInfo info;
  std::function<std::unique_ptr<System>(const SystemSetup&)> make;
};

/// The odometry of thesis 5.4 behind the interface.
class FrameToFrameSystem : public System {
 public:
  FrameToFrameSystem(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed)
      : odometry_(camera, options, seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }
  std::vector<FrameEstimate> Finish() override { return odometry_.Finish(); }

 private:
  FrameToFrameVo odometry_;
};

/// One composition, known by the detector it uses unless it is told another.
Entry FrameToFrame(const std::string& feature, double sensitivity, const std::string& description) {
  const std::string name = feature + "_vo";
  const FrameToFrameVoOptions defaults = FrameToFrameVoOptions::WithFeature(feature, sensitivity);
  return {{name, description, SettingsOf(defaults)}, [name, defaults](const SystemSetup& setup) {
            return std::make_unique<FrameToFrameSystem>(setup.calibration.camera,
                                                        OptionsFrom(setup.settings, name, defaults), setup.seed);
          }};
}

class MobifVoPlusSystem : public System {
 public:
  explicit MobifVoPlusSystem(const SystemSetup& setup)
      : odometry_(setup.calibration, OptionsFrom<MobifVoPlusOptions>(setup.settings, "mobif_vo_plus"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }
  std::vector<FrameEstimate> Finish() override { return odometry_.Finish(); }

 private:
  MobifVoPlus odometry_;
};

class FloorSlamSystem : public System {
 public:
  explicit FloorSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<FloorSlamOptions>(setup.settings, "floor_slam"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  std::vector<FrameEstimate> Finish() override { return slam_.Finish(); }
  std::optional<FloorPicture> Floor() const override { return slam_.Floor(); }

 private:
  FloorSlam slam_;
};

class TopoSlamSystem : public System {
 public:
  explicit TopoSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<TopoSlamOptions>(setup.settings, "topo_slam")) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  std::vector<FrameEstimate> Finish() override {
    slam_.Finish();
    return {};
  }
  std::optional<PlaceGraph> Places() const override { return slam_.graph(); }
  bool Acts() const override { return true; }
  BodyRequest Request() const override { return slam_.wants_scan() ? BodyRequest::kScan : BodyRequest::kGoOn; }
  std::string Failure() const override { return slam_.Failure(); }

 private:
  TopoSlam slam_;
};

/// Every system there is: a new one is one more line here.
std::vector<Entry> AllSystems() {
  std::vector<Entry> entries = {
      FrameToFrame("akaze", 4, "the odometry of mobif_vo with AKAZE features"),
      FrameToFrame("mobif", 4, "monocular odometry from pairs of frames (thesis 5.4) with MoBIF features"),
      FrameToFrame("orb", 4, "the odometry of mobif_vo with ORB features"),
      FrameToFrame("sift", 4, "the odometry of mobif_vo with SIFT features: the plain baseline"),
      FrameToFrame("surf", 4, "the odometry of mobif_vo with SURF features"),
      {{"floor_slam", "SLAM from the floor plane's homographies, with an intensity map of it (thesis, chapter 6)",
        SettingsOf(FloorSlamOptions())},
       [](const SystemSetup& setup) { return std::make_unique<FloorSlamSystem>(setup); }},
      {{"mobif_vo_plus",
        "monocular odometry for a shaking camera: blur-robust features, inverse depths, bundle adjustment",
        SettingsOf(MobifVoPlusOptions())},
       [](const SystemSetup& setup) { return std::make_unique<MobifVoPlusSystem>(setup); }},
      {{"topo_slam", "a map of places seen all around, 170 bytes each; the robot scans as it asks (thesis, chapter 4)",
        SettingsOf(TopoSlamOptions())},
       [](const SystemSetup& setup) { return std::make_unique<TopoSlamSystem>(setup); }},
  };
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.info.name < b.info.name; });
  return entries;
}

}  // namespace

std::string SettingValue::ToText() const { return number() ? internal::NumberText(*number()) : '"' + *text() + '"'; }

std::vector<SystemInfo> ListSystems() {
  std::vector<SystemInfo> infos;
  for (const Entry& entry : AllSystems()) infos.push_back(entry.info);
  return infos;
}

std::unique_ptr<System> MakeSystem(const std::string& name, const SystemSetup& setup) {
  std::vector<std::string> names;
  for (const Entry& entry : AllSystems()) {
    if (entry.info.name == name) return entry.make(setup);
    names.push_back(entry.info.name);
  }
  const std::string near = NearestWord(name, names);
  std::string all;
  for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
  throw BadInput("system " + name + ": there is no such system; " +
                 (near.empty() ? "known: " + all : "did you mean " + near + "?"));
}

}  // namespace gaitcam
