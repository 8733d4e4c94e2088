/// How a shared library offers a SLAM system: it includes this header, defines a class derived from System that is
/// constructed from a SystemSetup, and ends with
///
///   GAITCAM_SYSTEM_PLUGIN(MySlam, gaitcam::SystemInfo{"my_slam", "one line about it"})
///
/// A scenario then says `system: {plugin: ./libmy_slam.so}`. The library runs in a process of its own: it may crash,
/// print and take its time; that is scored as its failure.

#pragma once

#include <memory>

#include "algorithms/slam/system.h"

namespace gaitcam {

/// What a library offers.
struct SystemPlugin {
  SystemInfo info;
  std::unique_ptr<System> (*make)(const SystemSetup& setup) = nullptr;
};

/// Differs between programs whose types lie differently in memory: a library must have been built with this program's
/// headers.
constexpr uint64_t PluginLayout() {
  uint64_t layout = 1;  // of the functions' meaning
  for (const size_t size : {sizeof(Observation), sizeof(Calibration), sizeof(SystemSetup), sizeof(SystemInfo),
                            sizeof(FrameEstimate), sizeof(FinalEstimate), sizeof(BodyCommand), sizeof(SystemPlugin)}) {
    layout = layout * 1000003 + size;
  }
  return layout;
}

}  // namespace gaitcam

/// The two functions that the program looks for in the library.
#define GAITCAM_SYSTEM_PLUGIN(Class, ...)                                                        \
  extern "C" uint64_t gaitcam_plugin_layout() { return gaitcam::PluginLayout(); }                \
  extern "C" const void* gaitcam_plugin() {                                                      \
    static const gaitcam::SystemPlugin plugin{                                                   \
        __VA_ARGS__, [](const gaitcam::SystemSetup& setup) -> std::unique_ptr<gaitcam::System> { \
          return std::make_unique<Class>(setup);                                                 \
        }};                                                                                      \
    return &plugin;                                                                              \
  }
