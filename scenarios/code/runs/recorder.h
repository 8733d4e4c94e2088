/// One recording: simulate and write a dataset, without any SLAM.

#pragma once

#include "algorithms/io/dataset_writer.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {

struct RecordOptions {
  DatasetWriterOptions format;
  bool truth_images = true;  ///< Sharp twins, depth and blur vectors; else the numbers alone.
  bool quiet = false;
  std::function<bool()> interrupted = [] { return false; };
  std::function<void(int64_t frames, int64_t expected)> progress;  ///< Told after every frame; empty: a bar is shown.
};

struct RecordOutcome {
  DatasetFolders folders;
  std::string status;  ///< As of a run.
  double end_time_s = 0, distance_m = 0;
  int64_t frames = 0;
  RendererInfo renderer;
};

/// Removes both folders of a recording that cannot be completed, as far as that can be done.
void RemoveRecording(const DatasetFolders& folders);

/// Writes the two folders: what a SLAM system may see, and the truth beside it, the resolved scenario in it. Where the
/// scenario has a calibration error, the sensors' folder holds the wrong calibration and readings, and the truth's the
/// right calibration and what was drawn.
/// @throws BadInput, MissingResource.
RecordOutcome RecordScenario(const ResolvedScenario& resolved, const DatasetFolders& folders,
                             const RecordOptions& options);

}  // namespace gaitcam
