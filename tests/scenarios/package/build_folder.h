/// What packages and installations are made of.

#pragma once

#include <filesystem>

namespace gaitcam {

/// The folder that the tests were built in; it is not there when they are installed.
inline const std::filesystem::path kBuild = GAITCAM_BUILD_DIR;

}  // namespace gaitcam
