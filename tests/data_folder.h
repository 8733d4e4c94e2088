/// Where tests find robots, scenes and scenarios: in the installation that they belong to, else in the source folder.

#pragma once

#include <cstdlib>
#include <filesystem>

namespace gaitcam {

/// $GAITCAM_DATA, which the launcher sets, else the folder that the tests were built from.
inline std::filesystem::path TestData() {
  const char* named = std::getenv("GAITCAM_DATA");
  return named != nullptr ? named : GAITCAM_SOURCE_DIR;
}

/// Shipped robots and scenes.
inline const std::filesystem::path kModels = TestData() / "models";

}  // namespace gaitcam
