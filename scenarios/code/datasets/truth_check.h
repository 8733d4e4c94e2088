/// Consistency of the truth beside a recorded sequence, within itself and with the calibration.

#pragma once

#include "scenarios/code/datasets/image_check.h"
#include "scenarios/code/datasets/sequence_check.h"

namespace gaitcam {

/// Tables of poses, blur and sub-frames, the truth's images, pairs, the EuRoC states; and geometry: floor points of
/// depth and pose lie at height 0, blur vectors are what poses and depth imply, the calibration agrees with the floor
/// and with scenario.yaml.
/// @param frames of the sensors' folder. @param calibration nothing if it could not be read.
void CheckTruth(const DatasetFolders& folders, const std::vector<CheckedImage>& frames,
                const std::optional<Calibration>& calibration, SequenceReport& report);

}  // namespace gaitcam
