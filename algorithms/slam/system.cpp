#include "algorithms/slam/system.h"

#include <algorithm>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/odometry/keyframe_vo.h"
#include "algorithms/odometry/stereo_pair_vo.h"
#include "algorithms/odometry/stereo_vo.h"
#include "algorithms/odometry/two_view_vo.h"
#include "algorithms/slam/appearance_slam.h"
#include "algorithms/slam/floor_slam.h"
#include "algorithms/slam/hybrid_drive.h"
#include "algorithms/slam/hybrid_slam.h"
#include "algorithms/slam/pose_slam.h"
#include "algorithms/slam/settings.h"
#include "algorithms/slam/topo_slam.h"

namespace gaitcam {
namespace {

struct Entry {
  SystemInfo info;
  std::function<std::unique_ptr<System>(const SystemSetup&)> make;
};

class KeyframeVoSystem : public System {
 public:
  KeyframeVoSystem(const Calibration& calibration, const KeyframeVoOptions& options, uint64_t seed)
      : odometry_(calibration, options, seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }
  FinalEstimate Finish() override { return {odometry_.Finish(), {}, {}}; }

 private:
  KeyframeVo odometry_;
};

/// A preset of the keyframe odometry.
Entry Preset(const std::string& name, const std::string& description, const KeyframeVoOptions& defaults) {
  return {{name, description, ListFields(defaults), {}, false}, [name, defaults](const SystemSetup& setup) {
            return std::make_unique<KeyframeVoSystem>(setup.calibration, OptionsFrom(setup.settings, name, defaults),
                                                      setup.seed);
          }};
}

/// A preset called by its default detector.
/// @param sensitivity divides the detector's own threshold (results/studies/thresholds).
Entry KeyframeVoWith(const std::string& feature, const std::string& description,
                     double sensitivity = KeyframeVoOptions().sensitivity) {
  return Preset(feature + "_vo", description, KeyframeVoOptions::WithFeature(feature, sensitivity));
}

Entry MobifVoPlus() {
  KeyframeVoOptions options;
  options.rotation_before_map = true;
  options.window = 12;
  options.adjust_iterations = 20;
  return Preset("mobif_vo_plus",
                "the odometry of mobif_vo, with a longer window, and rotations predicted before there is a map",
                options);
}

class TwoViewVoSystem : public System {
 public:
  TwoViewVoSystem(const SystemSetup& setup, const TwoViewVoOptions& options)
      : odometry_(setup.calibration.camera, options, setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }

 private:
  TwoViewVo odometry_;
};

/// A preset of the two-view odometry.
Entry TwoViewPreset(const std::string& name, const std::string& description, const TwoViewVoOptions& defaults) {
  return {{name, description, ListFields(defaults), {}, false}, [name, defaults](const SystemSetup& setup) {
            return std::make_unique<TwoViewVoSystem>(setup, OptionsFrom(setup.settings, name, defaults));
          }};
}

class StereoPairVoSystem : public System {
 public:
  explicit StereoPairVoSystem(const SystemSetup& setup)
      : odometry_(setup.calibration, OptionsFrom<StereoPairVoOptions>(setup.settings, "stereo_pair_vo"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }

 private:
  StereoPairVo odometry_;
};

class StereoVoSystem : public System {
 public:
  explicit StereoVoSystem(const SystemSetup& setup)
      : odometry_(setup.calibration, OptionsFrom<StereoVoOptions>(setup.settings, "stereo_vo"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }
  FinalEstimate Finish() override { return {odometry_.Finish(), {}, {}}; }

 private:
  StereoVo odometry_;
};

class FloorSlamSystem : public System {
 public:
  explicit FloorSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<FloorSlamOptions>(setup.settings, "floor_slam"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  FinalEstimate Finish() override {
    FinalEstimate answer;
    answer.frames = slam_.Finish();
    answer.maps.emplace_back(slam_.Floor());
    return answer;
  }

 private:
  FloorSlam slam_;
};

class PoseSlamSystem : public System {
 public:
  explicit PoseSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<PoseSlamOptions>(setup.settings, "pose_slam"), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  FinalEstimate Finish() override {
    std::vector<FrameEstimate> frames = slam_.Finish();
    return {std::move(frames), {slam_.graph()}, {}};
  }

 private:
  PoseSlam slam_;
};

class HybridSlamSystem : public System {
 public:
  explicit HybridSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<HybridSlamOptions>(setup.settings, "hybrid_slam"), setup.seed),
        earlier_(setup.map) {
    if (earlier_) slam_.CheckFits(*earlier_);
  }
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  FinalEstimate Finish() override {
    std::vector<FrameEstimate> frames = slam_.Finish();
    return {std::move(frames), {slam_.graph(), earlier_ ? slam_.LearnedAfter(*earlier_) : slam_.Learned()}, {}};
  }

 private:
  HybridSlam slam_;
  std::shared_ptr<const RouteMap> earlier_;
};

class TopoSlamSystem : public System {
 public:
  explicit TopoSlamSystem(const SystemSetup& setup)
      : slam_(setup.calibration, OptionsFrom<TopoSlamOptions>(setup.settings, "topo_slam")) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  FinalEstimate Finish() override {
    slam_.Finish();
    return {{}, {slam_.graph()}, slam_.Failure()};
  }
  BodyCommand Command() const override { return slam_.wants_scan() ? BodyCommand(Scan()) : FollowPath(); }

 private:
  TopoSlam slam_;
};

class HybridDriveSystem : public System {
 public:
  explicit HybridDriveSystem(const SystemSetup& setup)
      : drive_(setup.calibration, setup.map, OptionsFrom<HybridDriveOptions>(setup.settings, "hybrid_drive"),
               setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return drive_.Track(observation); }
  FinalEstimate Finish() override { return {{}, {drive_.drive()}, {}}; }
  BodyCommand Command() const override { return drive_.command(); }

 private:
  HybridDrive drive_;
};

/// A system by name, whose options say what it is.
template <class Options>
class AppearanceSystem : public System {
 public:
  AppearanceSystem(const SystemSetup& setup, const std::string& name)
      : slam_(OptionsFrom<Options>(setup.settings, name), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return slam_.Track(observation); }
  FinalEstimate Finish() override {
    slam_.Finish();
    return {{}, {slam_.graph()}, {}};
  }

 private:
  AppearanceSlam slam_;
};

template <class Options>
Entry AppearanceEntry(const std::string& name, const std::string& description) {
  return {{name, description, ListFields(Options()), {}, false},
          [name](const SystemSetup& setup) { return std::make_unique<AppearanceSystem<Options>>(setup, name); }};
}

/// Every system there is: a new one is one more line here.
std::vector<Entry> MakeEntries() {
  std::vector<Entry> entries = {
      KeyframeVoWith("akaze", "the odometry of mobif_vo with AKAZE features"),
      Preset("mobif_vo", "monocular keyframe odometry with MoBIF features", KeyframeVoOptions()),
      MobifVoPlus(),
      KeyframeVoWith("orb", "the odometry of mobif_vo with ORB features", 4),
      KeyframeVoWith("sift", "the odometry of mobif_vo with SIFT features: the plain baseline"),
      KeyframeVoWith("surf", "the odometry of mobif_vo with SURF features"),
      {{"stereo_pair_vo",
        "stereo odometry from frame to frame, with error propagation in closed form (Valencia, chapter 2, alone)",
        ListFields(StereoPairVoOptions()),
        {SensorNeed::kStereo},
        false},
       [](const SystemSetup& setup) { return std::make_unique<StereoPairVoSystem>(setup); }},
      {{"stereo_vo",
        "stereo odometry with a covariance: landmarks, keyframes, a window of bundle adjustment (Valencia, chapter 2)",
        ListFields(StereoVoOptions()),
        {SensorNeed::kStereo},
        false},
       [](const SystemSetup& setup) { return std::make_unique<StereoVoSystem>(setup); }},
      TwoViewPreset("thesis_vo", "the monocular odometry of thesis 5.4: seven steps per pair of successive frames",
                    TwoViewVoOptions()),
      TwoViewPreset("icgm_vo", "thesis_vo with SURF and the matches that ICGM keeps: odometry for crowds (Hua 6.2)",
                    TwoViewVoOptions::OfCrowds()),
      {{"floor_slam",
        "SLAM from the floor plane's homographies, with an intensity map of it (thesis, chapter 6)",
        ListFields(FloorSlamOptions()),
        {SensorNeed::kStandingCamera},
        false},
       [](const SystemSetup& setup) { return std::make_unique<FloorSlamSystem>(setup); }},
      AppearanceEntry<PirfNavSlamOptions>(
          "pirf_nav", "a map of views that learns its words as it walks, and knows places by them (PIRF-nav 2.0)"),
      AppearanceEntry<IcgmSlamOptions>(
          "icgm_slam", "pirf_nav's map with features and loops that the geometry of crowds bears out (Hua 4.2)"),
      {{"hybrid_drive",
        "drives to a goal by a map that hybrid_slam learned, and waits for people in its way (Hua 6.1.2)",
        ListFields(HybridDriveOptions()),
        {SensorNeed::kDepth, SensorNeed::kOdometry},
        true,
        MapUse::kNeeded},
       [](const SystemSetup& setup) { return std::make_unique<HybridDriveSystem>(setup); }},
      {{"hybrid_slam",
        "depth camera and wheels or legs among people: linked views in space, loops by appearance (Hua 6.1)",
        ListFields(HybridSlamOptions()),
        {SensorNeed::kDepth},
        false,
        MapUse::kTaken},
       [](const SystemSetup& setup) { return std::make_unique<HybridSlamSystem>(setup); }},
      {{"pose_slam",
        "the odometry of stereo_vo, and a graph of its keyframes with loop closures and covariances",
        ListFields(PoseSlamOptions()),
        {SensorNeed::kStereo},
        false},
       [](const SystemSetup& setup) { return std::make_unique<PoseSlamSystem>(setup); }},
      {{"topo_slam",
        "a map of places seen all around, 170 bytes each; the robot scans as it asks (thesis, chapter 4)",
        ListFields(TopoSlamOptions()),
        {SensorNeed::kStandingCamera},
        true},
       [](const SystemSetup& setup) { return std::make_unique<TopoSlamSystem>(setup); }},
  };
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.info.name < b.info.name; });
  return entries;
}

const std::vector<Entry>& AllSystems() {
  static const std::vector<Entry> entries = MakeEntries();
  return entries;
}

const Entry& Find(const std::string& name) {
  std::vector<std::string> names;
  for (const Entry& entry : AllSystems()) {
    if (entry.info.name == name) return entry;
    names.push_back(entry.info.name);
  }
  throw BadInput("system " + name + ": there is no such system; " + DidYouMean(name, names));
}

bool Has(SensorNeed need, const Calibration& calibration, bool has_joints) {
  switch (need) {
    case SensorNeed::kStereo: return calibration.right.has_value();
    case SensorNeed::kDepth: return calibration.has_depth;
    case SensorNeed::kImu: return calibration.imu.rate_hz > 0;
    case SensorNeed::kJoints: return has_joints;
    case SensorNeed::kStandingCamera: return calibration.standing.has_value();
    case SensorNeed::kOdometry: return calibration.odometry.rate_hz > 0;
  }
  GAITCAM_ASSERT(false);
  return false;
}

}  // namespace

SystemSettings SystemInfo::Defaults() const {
  SystemSettings settings;
  for (const FieldInfo& option : options) settings[option.key] = option.default_value;
  return settings;
}

const std::vector<SystemInfo>& ListSystems() {
  static const std::vector<SystemInfo> infos = [] {
    std::vector<SystemInfo> list;
    for (const Entry& entry : AllSystems()) list.push_back(entry.info);
    return list;
  }();
  return infos;
}

const SystemInfo& InfoOfSystem(const std::string& name) { return Find(name).info; }

std::vector<SensorNeed> MissingSensors(const std::vector<SensorNeed>& needs, const Calibration& calibration,
                                       bool has_joints) {
  std::vector<SensorNeed> missing;
  for (const SensorNeed need : needs) {
    if (!Has(need, calibration, has_joints)) missing.push_back(need);
  }
  return missing;
}

std::unique_ptr<System> MakeSystem(const std::string& name, const SystemSetup& setup) { return Find(name).make(setup); }

}  // namespace gaitcam
