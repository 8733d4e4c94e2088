/// Writes a recorded walk, frame by frame, in the layout of `dataset_layout.h`.

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/frame_truth.h"
#include "algorithms/core/observation.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

struct DatasetWriterOptions {
  DatasetFormat format = DatasetFormat::kTum;
  /// Also puts groundtruth (and, in a TUM folder without a depth sensor, true depth) into the sensors' folder, where
  /// tools that score by themselves look for it. A SLAM system must then be trusted not to look.
  bool truth_inside = false;
  int png_compression = 1;  ///< 0 none, 1 fastest to 9 smallest; all are lossless.
  int threads = 2;          ///< That encode and write images beside the caller's; 0: Add() does it all. Same bytes.
};

/// Nothing has its final name before Finish(): an abandoned recording leaves nothing behind. Where a process is killed
/// between the names of the two folders, a mark in the truth's tells the next writer, which removes them.
///
/// Images are encoded on threads of the writer's own: pixels must not be altered after they were added.
class DatasetWriter {
 public:
  /// @throws BadInput if a folder exists already; MissingResource if it cannot be made; BadOption.
  DatasetWriter(const DatasetFolders& folders, const Calibration& calibration, const DatasetWriterOptions& options);
  /// Without Finish(), removes what was written.
  ~DatasetWriter();

  /// Frames come with increasing stamps. Memory does not grow with their number: where the disk is slower than the
  /// caller, the caller waits.
  /// @throws BadInput if the observation is not what the calibration says (image size, a missing right image or depth);
  /// MissingResource if the disk is full, at the latest in Finish().
  void Add(const Observation& observation, const std::optional<FilmedTruth>& truth);

  /// A file of this text beside the truth. @throws MissingResource.
  void AddToTruth(const std::string& name, const std::string& text);

  /// Gives the folders their names. @param ending how the recording ended, for about.txt: "finished", "fell at 3.2 s".
  void Finish(const std::string& ending);

  int64_t frames() const;

 private:
  class Files;
  std::unique_ptr<Files> files_;
};

}  // namespace gaitcam
