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

}  // namespace gaitcam
