/// Trajectory files, in and out: TUM, KITTI, EuRoC.
///
/// TUM:   `stamp tx ty tz qx qy qz qw`, stamp in seconds, `#` starts a comment.
/// EuRoC: `stamp, tx, ty, tz, qw, qx, qy, qz[, more]`, stamp in nanoseconds, comma-separated, `#` starts a comment.
/// KITTI: the twelve numbers of the 3 x 4 matrix [R t], row by row; no stamps: line k is at k seconds.

#pragma once

#include <filesystem>
#include <string>

#include "algorithms/core/trajectory.h"

namespace gaitcam {

enum class TrajectoryFormat { kTum, kKitti, kEuroc };

/// "tum", "kitti", "euroc".
std::string ToString(TrajectoryFormat format);

/// A file's poses X_WC and what its content says it is: commas mean EuRoC, 8 columns TUM, 12 columns KITTI.
struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  Trajectory trajectory;
};

/// @throws BadInput `file:line: ...` for a file that cannot be read, a line with the wrong number of columns, something
/// that is not a finite number, a quaternion further than 1e-2 from unit length, a matrix further than 1e-2 from a
/// rotation, stamps that do not increase, or no pose at all.
TrajectoryFile ReadTrajectory(const std::filesystem::path& file);

/// Stamps round-trip exactly; so do positions, which are written with the shortest text that reads back the same.
std::string TrajectoryToText(const Trajectory& trajectory, TrajectoryFormat format);

/// Writes under a temporary name, then renames. @throws MissingResource if the file cannot be written.
void WriteTrajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format);

/// Nanoseconds of a decimal number of seconds ("12.034", "1403636580.83"), exactly, up to 18 significant digits;
/// rounded beyond nine decimals. @returns false if `text` is not such a number.
bool ParseSeconds(const std::string& text, int64_t& stamp_ns);

/// Seconds with nine decimals.
std::string SecondsText(int64_t stamp_ns);

}  // namespace gaitcam
