/// One recording: simulate and write a dataset, without any SLAM.

#pragma once

#include "algorithms/io/dataset_writer.h"
#include "scenarios/runner.h"

namespace gaitcam {

struct RecordOutcome {
  DatasetFolders folders;
  std::string status;  ///< As of a run.
  double end_time_s = 0;
  int64_t frames = 0;
};

/// Writes OUT/NAME (what a SLAM system may see) and OUT/NAME-truth beside it, NAME being the scenario's.
/// @throws BadInput, MissingResource.
RecordOutcome RecordScenario(const ResolvedScenario& resolved, const DatasetWriterOptions& format,
                             const RunOptions& options);

}  // namespace gaitcam
