/// A walk that renders in a second or two: for tests of what is done with recordings.

#pragma once

#include <filesystem>
#include <fstream>

#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/recorder.h"

namespace gaitcam {

/// It stands for 0.3 s, then walks a circle; 160 x 120 px, 10 Hz, four instants per image.
inline const char* const kTinyWalk = R"(
duration_s: 2
gait: {preset: brisk}
path: {kind: circle, diameter_m: 4, settle_s: 0.3}
camera: {width_px: 160, height_px: 120, rate_hz: 10, exposure_ms: 10, fixed_subframes: 4}
)";

/// Records it in this process.
inline DatasetFolders RecordTinyWalk(const std::filesystem::path& folder, const std::string& format,
                                     const std::vector<std::string>& changes = {}) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "walk.yaml") << kTinyWalk;
  RecordOptions options;
  options.quiet = true;
  options.format.format = DatasetFormatFromText(format);
  const ResolvedScenario resolved = ReadScenario(folder / "walk.yaml", changes);
  return RecordScenario(resolved, DatasetFolders::In(folder, "walk"), options).folders;
}

}  // namespace gaitcam
