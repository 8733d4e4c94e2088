/// The files beside the sequences of a dataset: index.csv, README.md, SHA256SUMS.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/code/datasets/record_matrix.h"

namespace gaitcam {

/// One row per finished sequence: name, the value of every axis, seed, measurements, folder.
std::string DatasetIndex(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records);

/// The data card, Markdown. @param out the dataset's folder, whose first sequence says what settings there are.
std::string DatasetCard(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records,
                        const std::filesystem::path& out);

/// Writes all three. @throws MissingResource.
void WriteDatasetFiles(const std::filesystem::path& out, const RecordMatrix& matrix,
                       const std::vector<SequenceRecord>& records);

}  // namespace gaitcam
