/// Validation of one recorded sequence against its layout (algorithms/io/dataset_layout.h): tables, images, samples,
/// calibration and, if the truth lies beside it, poses, blur, pairs and the intrinsics that these imply.

#pragma once

#include <optional>
#include <vector>

#include "algorithms/io/dataset_layout.h"
#include "scenarios/code/datasets/checked_table.h"
#include "scenarios/code/datasets/floor_intrinsics.h"

namespace gaitcam {

struct SequenceReport {
  Problems problems;  ///< All that can be found; an earlier one hides none that can be checked without it.
  int64_t frames = 0, images = 0;
  bool with_truth = false;
  std::optional<FloorIntrinsics> floor;  ///< Intrinsics estimated from the floor.
};

/// Reads every table and every image. `folders.truth` may not exist.
SequenceReport CheckSequence(const DatasetFolders& folders);

}  // namespace gaitcam
