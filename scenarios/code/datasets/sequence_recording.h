/// One sequence of a dataset: recorded with pairs, pictures and checksums; it gets its name when it is complete.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "algorithms/core/fields.h"
#include "algorithms/io/dataset_writer.h"
#include "scenarios/code/datasets/frame_pairs.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

/// `pairs: true`, or `pairs: {every: 5, gap: 2}`.
struct PairChoice : PairOptions {};
void ReadOption(const OptionValue& node, PairChoice& value);

/// Options that determine a sequence's files besides its scenario.
struct SequenceOptions {
  using DescribedTag = void;
  DatasetFormat format = DatasetFormat::kTum;
  bool truth_inside = false;
  bool preview = true;
  int compression = DatasetWriterOptions().png_compression;
  PairChoice pairs;

  DatasetWriterOptions WriterOptions() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, SequenceOptions& o) {
  visit("format", o.format, EnumWords<DatasetFormat>(), "layout of the sequences: TUM RGB-D, EuRoC ASL or VSLAM-LAB");
  visit("truth_inside", o.truth_inside, Nested(), "also put the ground truth where the layout's own tools look for it");
  visit("preview", o.preview, Nested(), "preview.mp4 and contact_sheet.png beside the truth");
  visit("compression", o.compression, Between(0, 9),
        "of images, all lossless: 0 none, which takes no time, 1 fast to 9 smallest");
  visit("pairs", o.pairs, Nested(), "true | {every, gap, points}: pairs of frames with true correspondences");
}

/// The record of a finished sequence: sequence.json beside its truth.
struct SequenceRecord {
  std::string name;
  std::string recipe;  ///< RecipeOf its scenario and options.
  std::string status;  ///< How the walk ended: "finished", "fell".
  double end_time_s = 0, distance_m = 0;
  int64_t frames = 0;
  int pairs = 0;
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;  ///< Over the frames' medians.
  RendererInfo renderer;
  std::string program, frames_fingerprint;  ///< Versions that made it.
};

/// SHA-256 over the hash of the scenario's frames and the options: what determines a sequence's files.
std::string RecipeOf(const ResolvedScenario& resolved, const SequenceOptions& options);

/// Adds pairs and pictures to a recording. @returns its record, still without name and recipe.
/// @throws BadInput, MissingResource.
SequenceRecord DescribeRecording(const DatasetFolders& folders, const SequenceOptions& options,
                                 const std::string& title);

/// Records into FOLDER/NAME and FOLDER/NAME-truth. Until both are complete they lie in FOLDER/.NAME.part-PID; the
/// sensors' folder is renamed last, so that its existence means a complete sequence.
/// @returns nothing if interrupted; then no files are left. @throws BadInput, MissingResource.
std::optional<SequenceRecord> RecordSequence(const ResolvedScenario& resolved, const std::filesystem::path& folder,
                                             const std::string& name, const SequenceOptions& options,
                                             const std::function<void(int64_t, int64_t)>& progress,
                                             const std::function<bool()>& interrupted);

/// A finished sequence; nothing if there is none. A truth folder without its sensors, left by a kill, is removed.
/// @throws BadInput if its record is damaged.
std::optional<SequenceRecord> FindSequence(const std::filesystem::path& folder, const std::string& name);

/// The file of a sequence's checksums, in the format of `sha256sum`, relative to the folder of the sequences.
std::filesystem::path SumsOf(const std::filesystem::path& folder, const std::string& name);

/// Rows of `sha256sum` for all files below `folders`, sorted, named relative to `base`.
std::string ChecksumRows(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& base);

}  // namespace gaitcam
