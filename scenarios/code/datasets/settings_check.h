/// Validation of the settings files that a recording holds for other programs.

#pragma once

#include <filesystem>

#include "algorithms/core/camera.h"
#include "algorithms/io/dataset_layout.h"
#include "scenarios/code/datasets/checked_table.h"

namespace gaitcam {

/// Every file of SettingsOf (algorithms/io/program_settings.h) must be there and say what the calibration does; so must
/// VSLAM-LAB's calibration.yaml, and ORB-SLAM's list of stamps hold those of the frames.
/// @param frames stamps, ns.
void CheckSettings(const std::filesystem::path& dataset, DatasetFormat format, const Calibration& calibration,
                   const std::vector<int64_t>& frames, Problems& problems);

}  // namespace gaitcam
