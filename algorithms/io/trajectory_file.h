/// Trajectory files, in and out, in the three formats that everybody's tools read.
///
///   TUM    "t x y z qx qy qz qw" per line, t in seconds (nine decimals are written: stamps come back exactly)
///   KITTI  the upper 3 x 4 of the pose matrix, row by row, 12 numbers per line; it has no stamps
///   EuRoC  CSV "t,x,y,z,qw,qx,qy,qz[,...]", t in nanoseconds; further columns are skipped when read
///
/// Poses are read as they stand. Which frame's poses a file holds, it cannot say: TUM and KITTI files usually hold the
/// camera's, EuRoC's ground truth the body's (the IMU's).

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

enum class TrajectoryFormat { kTum, kKitti, kEuroc };
constexpr auto WordsOf(TrajectoryFormat) {
  return std::array{EnumWord{TrajectoryFormat::kTum, "tum"}, EnumWord{TrajectoryFormat::kKitti, "kitti"},
                    EnumWord{TrajectoryFormat::kEuroc, "euroc"}};
}

/// "tum", "kitti", "euroc".
std::string ToString(TrajectoryFormat format);
/// @throws BadInput naming the unknown word and the known ones.
TrajectoryFormat TrajectoryFormatFromText(const std::string& text);

/// What is done about stamps that do not increase: files of real recordings have such. The TUM benchmark's own truth of
/// freiburg2_desk holds a stamp twice, and so may ORB-SLAM's files of key frames.
enum class StampOrder { kStrict, kRepaired };

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  Trajectory trajectory;
  std::vector<std::string> remarks;  ///< What was repaired, a line each.
};

/// Reads a trajectory; unless said, its format is told by the first row: commas mean EuRoC, 12 numbers KITTI, 8 TUM.
/// A KITTI file's stamps are taken from `kitti_times` (one time in seconds per line), or are its row numbers as
/// seconds.
/// @param order kRepaired: rows are sorted by their stamps, of equal ones the first in the file is kept, and both are
/// remarked.
/// @throws BadInput "file:line: what is wrong and what would be right": not a number, too few or too many fields, a
/// quaternion or matrix that is no rotation, stamps that do not increase (kStrict), no pose at all.
TrajectoryFile ReadTrajectory(const std::filesystem::path& file, std::optional<TrajectoryFormat> format = {},
                              const std::filesystem::path& kitti_times = {}, StampOrder order = StampOrder::kStrict);

/// Sorts by stamps, and keeps the first of equal ones.
/// @param name of the file, for the remarks
/// @returns what there was to do, a line each
std::vector<std::string> RepairStamps(const std::string& name, Trajectory& trajectory);

/// Writes a whole file or none. Numbers are written so that they read back to the same bits (KITTI's rotation: to
/// 1e-15).
/// @throws MissingResource if it cannot be written.
void WriteTrajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format);

/// One row without its line end, for those who write row by row.
std::string TrajectoryRow(const StampedPose& pose, TrajectoryFormat format);
/// The comment line that stands first in a file of this format, with its line end; empty for KITTI.
std::string TrajectoryHeader(TrajectoryFormat format);

}  // namespace gaitcam
