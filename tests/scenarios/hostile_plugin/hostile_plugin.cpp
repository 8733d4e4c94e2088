// A system in a shared library that misbehaves at the second frame, in the way that its setting names.

#include <csignal>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "algorithms/slam/plugin.h"
#include "algorithms/slam/settings.h"

namespace {

struct HostileOptions {
  using DescribedTag = void;
  std::string deed = "throw";
};

template <class Visitor>
void VisitFields(Visitor& visit, HostileOptions& o) {
  visit("deed", o.deed, gaitcam::AnyText(), "what it does at the second frame");
}

class HostileSystem : public gaitcam::System {
 public:
  explicit HostileSystem(const gaitcam::SystemSetup& setup)
      : options_(gaitcam::OptionsFrom<HostileOptions>(setup.settings, "hostile")) {}

  gaitcam::FrameEstimate Track(const gaitcam::Observation& observation) override {
    gaitcam::FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = gaitcam::TrackingStatus::kTracking;
    answer.pose.emplace();
    if (++frames_ == 2) Misbehave(answer);
    return answer;
  }

 private:
  void Misbehave(gaitcam::FrameEstimate& answer) const {
    if (options_.deed == "throw") throw std::runtime_error("on purpose");
    if (options_.deed == "throw_number") throw 42;
    if (options_.deed == "abort") std::abort();
    if (options_.deed == "exit") std::_Exit(0);
    if (options_.deed == "write_to_nowhere") std::raise(SIGSEGV);
    if (options_.deed == "nan") answer.pose->translation.x() = std::numeric_limits<double>::quiet_NaN();
    for (volatile bool forever = options_.deed == "loop"; forever;) continue;
  }

  HostileOptions options_;
  int frames_ = 0;
};

}  // namespace

GAITCAM_SYSTEM_PLUGIN(HostileSystem, gaitcam::SystemInfo{
                                         "hostile", "misbehaves on purpose", gaitcam::ListFields(HostileOptions()), {}})
