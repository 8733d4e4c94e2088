/// Whether one recorded sequence is what its layout (algorithms/io/dataset_layout.h) says: tables, images, samples,
/// calibration, and, if it has its truth beside it, poses, blur, pairs and the intrinsics that these imply.

#pragma once

#include <optional>
#include <vector>

#include "algorithms/io/dataset_layout.h"
#include "scenarios/datasets/checked_table.h"
#include "scenarios/datasets/floor_intrinsics.h"

namespace gaitcam {

struct SequenceReport {
  Problems problems;  ///< Nothing is left out because of an earlier one, but what cannot be looked at at all.
  int64_t frames = 0, images = 0;
  bool with_truth = false;
  std::optional<FloorIntrinsics> floor;  ///< What the floor says of the intrinsics.
};

/// Reads every table and every image. `folders.truth` may not exist.
SequenceReport CheckSequence(const DatasetFolders& folders);

}  // namespace gaitcam
