/// Reads a dataset folder, frame by frame, as the observations that a SLAM system gets. Ours come back to the bit; TUM
/// RGB-D, EuRoC ASL and VSLAM-LAB folders by others are read too.

#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

struct DatasetReaderOptions {
  /// Replaces the folder's own calibration. A TUM folder of somebody else's needs one; EuRoC says it in sensor.yaml,
  /// VSLAM-LAB in calibration.yaml.
  std::filesystem::path calibration;
  /// How far apart the stamps of one frame's images may be, where a folder's streams are not synchronous.
  double max_stamp_difference_s = 0.02;
};

class DatasetReader {
 public:
  /// Reads the calibration and checks the tables' first rows; images are read when their turn comes.
  /// @throws BadInput naming file, line and what would be right.
  explicit DatasetReader(const std::filesystem::path& folder, const DatasetReaderOptions& options = {});
  ~DatasetReader();

  DatasetFormat format() const;
  const Calibration& calibration() const;
  /// Rows of the table of (left) images.
  int64_t frames() const;

  /// The next frame, in time order; nothing after the last. Memory does not grow with the number of frames.
  /// Where the folder does not say the exposure, `exposure_ms` is 0. A frame of a stereo or RGB-D rig whose other image
  /// is missing comes without it.
  /// @throws BadInput naming file and line: an image that is missing, cannot be decoded or has another size; stamps
  /// that do not increase; a row that is not what the layout says.
  std::optional<Observation> Next();

 private:
  class Source;
  std::unique_ptr<Source> source_;
};

}  // namespace gaitcam
