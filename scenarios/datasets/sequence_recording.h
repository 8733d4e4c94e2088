/// One sequence of a dataset: recorded, with pairs, pictures and checksums, and named only when all of it is there.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "algorithms/core/fields.h"
#include "algorithms/io/dataset_writer.h"
#include "scenarios/datasets/frame_pairs.h"
#include "scenarios/scenario.h"

namespace gaitcam {

/// `pairs: true`, or `pairs: {every: 5, gap: 2}`.
struct PairChoice : PairOptions {};
void ReadYaml(const YamlNode& node, PairChoice& value);

/// What decides a sequence's files besides its scenario.
struct SequenceOptions {
  using DescribedTag = void;
  std::string format = "tum";
  bool truth_inside = false;
  bool preview = true;
  PairChoice pairs;

  DatasetWriterOptions WriterOptions() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, SequenceOptions& o) {
  visit("format", o.format, OneOf({"tum", "euroc"}), "layout of the sequences: TUM RGB-D or EuRoC ASL");
  visit("truth_inside", o.truth_inside, Nested(), "also put the ground truth where the layout's own tools look for it");
  visit("preview", o.preview, Nested(), "preview.mp4 and contact_sheet.png beside the truth");
  visit("pairs", o.pairs, Nested(), "true | {every, gap, points}: pairs of frames with what is true between them");
}

/// What a finished sequence says of itself: sequence.json beside its truth.
struct SequenceRecord {
  std::string name;
  std::string recipe;  ///< RecipeOf what it was made from.
  std::string status;  ///< How the walk ended: "finished", "fell".
  double end_time_s = 0, distance_m = 0;
  int64_t frames = 0;
  int pairs = 0;
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;  ///< Over the frames' medians.
  std::string renderer;
  bool software_renderer = false;
  std::string program, frames_fingerprint;  ///< Versions that made it.
};

/// SHA-256 of what decides a sequence's files: the scenario's frames and the options.
std::string RecipeOf(const ResolvedScenario& resolved, const SequenceOptions& options);

/// Adds pairs and pictures to a recording. @returns its record, still without name and recipe.
/// @throws BadInput, MissingResource.
SequenceRecord DescribeRecording(const DatasetFolders& folders, const SequenceOptions& options,
                                 const std::string& title);

/// Records into FOLDER/NAME and FOLDER/NAME-truth. Until both are whole they lie in FOLDER/.NAME.part-PID; the sensors'
/// folder is named last, so that a sequence whose folder is there is whole.
/// @returns nothing if interrupted; then nothing is left. @throws BadInput, MissingResource.
std::optional<SequenceRecord> RecordSequence(const ResolvedScenario& resolved, const std::filesystem::path& folder,
                                             const std::string& name, const SequenceOptions& options,
                                             const std::function<void(int64_t, int64_t)>& progress,
                                             const std::function<bool()>& interrupted);

/// A finished sequence; nothing if there is none. Half of one that a kill left between its two names is removed.
/// @throws BadInput if its record is damaged.
std::optional<SequenceRecord> FindSequence(const std::filesystem::path& folder, const std::string& name);

/// Where a sequence's checksums stand, as `sha256sum` prints them, relative to the folder of the sequences.
std::filesystem::path SumsOf(const std::filesystem::path& folder, const std::string& name);

/// Rows of `sha256sum` for all files below `folders`, sorted, named relative to `base`.
std::string ChecksumRows(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& base);

}  // namespace gaitcam
