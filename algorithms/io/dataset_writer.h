/// Writes a recorded walk, frame by frame, in the layout of `dataset_layout.h`.

#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/pose.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

/// What is true of one frame, as far as it is known. Images may be empty.
struct FrameTruthRecord {
  /// One instant of the exposure.
  struct SubPose {
    int64_t stamp_ns = 0;
    double weight = 0;
    Pose X_WC;
  };

  Pose X_WC;                                  ///< Left camera at mid-exposure.
  std::optional<Pose> X_WC_open, X_WC_close;  ///< At the shutter's opening and close.
  std::optional<Pose> X_WI;                   ///< The IMU; without it X_WC * X_CI is taken, the neck being at rest.
  std::optional<Pose> X_WB;                   ///< The robot's root.
  std::vector<SubPose> subposes;
  cv::Mat sharp;  ///< CV_8UC1 or CV_8UC3: the left image without blur and noise.
  cv::Mat depth;  ///< CV_32FC1, m; 0 where nothing was hit.
  cv::Mat blur;   ///< CV_32FC2, px from shutter open to close; NaN where unknown.
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;
  int step = -1;          ///< Of the gait; -1 while standing.
  double step_phase = 0;  ///< 0..1 within the step.
  bool left_contact = false, right_contact = false;
};

struct DatasetWriterOptions {
  DatasetFormat format = DatasetFormat::kTum;
  /// Also puts groundtruth (and, in a TUM folder without a depth sensor, true depth) into the sensors' folder, where
  /// tools that score by themselves look for it. A SLAM system must then be trusted not to look.
  bool truth_inside = false;
  int png_compression = 1;  ///< 1 fastest to 9 smallest; all are lossless.
  int threads = 2;          ///< That encode and write images beside the caller's; 0: Add() does it all. Same bytes.
};

/// Nothing has its final name before Finish(): an abandoned recording leaves nothing behind.
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
  void Add(const Observation& observation, const std::optional<FrameTruthRecord>& truth);

  /// Gives the folders their names. @param ending how the recording ended, for about.txt: "finished", "fell at 3.2 s".
  void Finish(const std::string& ending);

  int64_t frames() const;

 private:
  class Files;
  std::unique_ptr<Files> files_;
};

}  // namespace gaitcam
