/// What lies beside a fuzzed file: other files that its content may name, and datasets in which one table is fuzzed.

#pragma once

#include <filesystem>
#include <string>

#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

/// A file of these bytes in a folder of this process, in memory where there is such a place; the folder is removed when
/// the process ends. Beside it lie `grid.png` of a map, a scenario `base.yaml` of half a second, and the URDF files of
/// two robots.
/// @param name of the file
std::filesystem::path FuzzFile(const std::string& bytes, const std::string& name);

/// A dataset of four frames from a stereo rig with an inertial sensor and odometry, good but for the file `table`,
/// which holds these bytes.
std::filesystem::path FuzzDataset(const std::string& bytes, DatasetFormat format, const std::string& table);

}  // namespace gaitcam
