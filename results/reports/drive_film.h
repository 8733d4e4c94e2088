/// A film of a drive by a taught map, seen from above: the taught way, the robot and where it looks, the way it has
/// driven, people and their tracks, where views of the map confirmed its place and where it waited.
///
/// It plays four times as fast as the drive went.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "algorithms/core/taught_drive.h"
#include "results/scoring/drive_score.h"

namespace gaitcam {

inline constexpr const char* kDriveFilmName = "drive.mp4";

/// The picture of step `step` of the drive. CV_8UC3, `height_px` high; its width follows from the ground's shape and is
/// the same for every step.
/// @pre the step has a true place.
cv::Mat DriveFilmPicture(const TaughtDrive& drive, const DriveComparison& comparison, size_t step, int height_px);

/// Steps without a true place are left out; nothing is written if no two are left.
/// @throws MissingResource as VideoWriter.
void WriteDriveFilm(const std::filesystem::path& file, const TaughtDrive& drive, const DriveComparison& comparison);

}  // namespace gaitcam
