/// Validation of a dataset: each sequence and, of a matrix, the index, the data card and the checksums.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/code/datasets/sequence_check.h"

namespace gaitcam {

struct DatasetReport {
  struct Sequence {
    std::string name;
    int64_t frames = 0;
    bool with_truth = false;
    std::optional<FloorIntrinsics> floor;
  };
  Problems problems;
  std::vector<Sequence> sequences;
  int64_t frames = 0, images = 0, files_summed = 0;
};

/// @param folder what `record` wrote of a matrix (index.csv in it), OUT of one recording (NAME and NAME-truth in it),
/// or a folder of sensors, recorded by gaitcam or not; its truth is looked for beside it.
/// @throws BadInput if it is none of these.
DatasetReport CheckDataset(const std::filesystem::path& folder);

}  // namespace gaitcam
