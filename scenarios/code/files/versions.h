/// Versions of gaitcam and of the libraries that decide its numbers.

#pragma once

#include <string>
#include <utility>
#include <vector>

namespace gaitcam {

using Facts = std::vector<std::pair<std::string, std::string>>;

/// gaitcam, MuJoCo, OpenCV, Eigen, Ceres, compiler: name and version.
Facts LibraryVersions();

/// What goes into a report besides the scenario: seed and versions.
Facts RunFacts(uint64_t seed);

/// gaitcam's own version, "0.1.0".
std::string ProgramVersion();

/// Changes whenever the code that makes frames does (core, io, models, sim, variations), or MuJoCo.
std::string FramesFingerprint();

/// Changes whenever the running program's bytes do: its SHA-256.
std::string ProgramFingerprint();

}  // namespace gaitcam
