#include "algorithms/slam/system.h"

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/odometry/mobif_vo_plus.h"
#include "algorithms/odometry/sift_vo.h"
#include "algorithms/slam/settings.h"

namespace gaitcam {
namespace {

struct Entry {
  SystemInfo info;
  std::function<std::unique_ptr<System>(const SystemSetup&)> make;
};

/// A monocular odometry behind the interface.
template <class Odometry, class Options>
class MonocularSystem : public System {
 public:
  MonocularSystem(const SystemSetup& setup, const std::string& name)
      : odometry_(setup.calibration.camera, OptionsFrom<Options>(setup.settings, name), setup.seed) {}
  FrameEstimate Track(const Observation& observation) override { return odometry_.Track(observation); }

 private:
  Odometry odometry_;
};

template <class Odometry, class Options>
Entry Monocular(const std::string& name, const std::string& description) {
  return {{name, description, SettingsOf(Options())}, [name](const SystemSetup& setup) {
            return std::make_unique<MonocularSystem<Odometry, Options>>(setup, name);
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

/// Every system there is: a new one is one more line here.
std::vector<Entry> AllSystems() {
  std::vector<Entry> entries = {
      Monocular<SiftVo, SiftVoOptions>("sift_vo", "plain monocular odometry: SIFT, five-point RANSAC, keyframe points"),
      {{"mobif_vo_plus",
        "monocular odometry for a shaking camera: blur-robust features, inverse depths, bundle adjustment",
        SettingsOf(MobifVoPlusOptions())},
       [](const SystemSetup& setup) { return std::make_unique<MobifVoPlusSystem>(setup); }},
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
