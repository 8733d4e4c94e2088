/// A recording together with its truth, as tables: which files belong to each frame, and what is true of it.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/frame_truth.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

/// What a recording's frames.csv says of each frame: poses at shutter open and close, and blur.
/// @throws BadInput naming file and line.
std::vector<FrameTruth> ReadRecordedTruth(const DatasetFolders& folders);

/// Files are empty paths where a recording has none.
struct RecordedFrame : FrameTruth {
  double exposure_ms = 0;
  std::filesystem::path image, sharp, depth, blur;
};

struct RecordedWalk {
  DatasetFolders folders;
  Calibration calibration;  ///< The right one.
  std::vector<RecordedFrame> frames;
};

/// Reads tables, not images. Frames without truth are left out.
/// @throws BadInput naming file and line.
RecordedWalk ReadRecordedWalk(const DatasetFolders& folders);

/// CV_32FC1 m along the optical axis at mid-exposure, 0 where nothing is; the lossless twin where there is one.
/// @throws BadInput.
cv::Mat ReadTrueDepth(const RecordedWalk& walk, const RecordedFrame& frame);

/// Of the frames' median blur: median, 90 % and maximum.
struct BlurSummary {
  double median_px = 0, p90_px = 0, max_px = 0;
};
BlurSummary SummariseBlur(const RecordedWalk& walk);

}  // namespace gaitcam
