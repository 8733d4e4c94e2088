#include "scenarios/code/datasets/sequence_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/whole_file.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/datasets/preview.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/calibration_error.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/recorder.h"
#include "scenarios/code/runs/renderer_record.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRecord = "sequence.json";
constexpr const char* kChecksums = "files.sha256";
constexpr const char* kSchema = "gaitcam.sequence.1";

nlohmann::ordered_json ToJson(const SequenceRecord& r) {
  nlohmann::ordered_json json{{"schema", kSchema},
                              {"name", r.name},
                              {"recipe", r.recipe},
                              {"status", r.status},
                              {"end_time_s", r.end_time_s},
                              {"distance_m", r.distance_m},
                              {"frames", r.frames},
                              {"pairs", r.pairs},
                              {"blur_median_px", r.blur_median_px},
                              {"blur_p90_px", r.blur_p90_px},
                              {"blur_max_px", r.blur_max_px},
                              {"program", r.program},
                              {"frames_fingerprint", r.frames_fingerprint}};
  WriteRenderer(r.renderer, json);
  return json;
}

SequenceRecord FromJson(const nlohmann::json& json) {
  SequenceRecord r;
  r.name = json.at("name");
  r.recipe = json.at("recipe");
  r.status = json.at("status");
  r.end_time_s = json.at("end_time_s");
  r.distance_m = json.at("distance_m");
  r.frames = json.at("frames");
  r.pairs = json.at("pairs");
  r.blur_median_px = json.at("blur_median_px");
  r.blur_p90_px = json.at("blur_p90_px");
  r.blur_max_px = json.at("blur_max_px");
  r.renderer = ReadRenderer(json);
  r.program = json.at("program");
  r.frames_fingerprint = json.at("frames_fingerprint");
  return r;
}

/// Both folders get their names, or none does.
void Rename(const DatasetFolders& from, const DatasetFolders& to) {
  const auto refuse = [](const fs::path& folder, const std::error_code& error) {
    throw MissingResource(folder.string() + ": cannot name this folder: " + error.message());
  };
  std::error_code error, ignored;
  fs::rename(from.truth, to.truth, error);
  if (error) refuse(to.truth, error);
  fs::rename(from.sensors, to.sensors, error);
  if (!error) return;
  fs::rename(to.truth, from.truth, ignored);
  refuse(to.sensors, error);
}

}  // namespace

void ReadOption(const OptionValue& node, PairChoice& value) {
  if (node.IsMap()) {
    value.enabled = true;
    ReadOption(node, static_cast<PairOptions&>(value));
  } else {
    ReadOption(node, value.enabled);
  }
}

DatasetWriterOptions SequenceOptions::WriterOptions() const {
  DatasetWriterOptions options;
  options.format = format;
  options.truth_inside = truth_inside;
  options.png_compression = compression;
  return options;
}

std::string RecipeOf(const ResolvedScenario& resolved, const SequenceOptions& options) {
  YAML::Emitter out;
  WriteYaml(out, options);
  std::string text = FramesHashOf(resolved) + "\n" + out.c_str();
  for (const auto& [name, value] : CalibrationErrorFacts(resolved)) text += "\n" + name + ": " + value;
  return Sha256(text);
}

SequenceRecord DescribeRecording(const DatasetFolders& folders, const SequenceOptions& options,
                                 const std::string& title) {
  const RecordedWalk walk = ReadRecordedWalk(folders);
  const BlurSummary blur = SummariseBlur(walk);
  SequenceRecord record;
  record.blur_median_px = blur.median_px;
  record.blur_p90_px = blur.p90_px;
  record.blur_max_px = blur.max_px;
  if (options.pairs.enabled) record.pairs = WriteFramePairs(walk, options.pairs);
  if (!options.preview) return record;
  WritePreview(walk, folders.truth / "preview.mp4");
  WriteContactSheet(
      walk, fmt::format("{}: blur {:.1f} px (90 % of the frames: up to {:.1f})", title, blur.median_px, blur.p90_px),
      folders.truth / "contact_sheet.png");
  return record;
}

std::optional<SequenceRecord> RecordSequence(const ResolvedScenario& resolved, const fs::path& folder,
                                             const std::string& name, const SequenceOptions& options,
                                             const std::function<void(int64_t, int64_t)>& progress,
                                             const std::function<bool()>& interrupted) {
  RemoveUnfinished(folder / name);
  OutputFolder unfinished(folder / name, "");  // only its temporary folder is used: two folders are made from it
  const DatasetFolders folders = DatasetFolders::In(unfinished.path(), name), wanted = DatasetFolders::In(folder, name);
  RecordOptions recording;
  recording.format = options.WriterOptions();
  recording.quiet = true;
  recording.progress = progress;
  recording.interrupted = interrupted;
  const RecordOutcome outcome = RecordScenario(resolved, folders, recording);
  if (outcome.status == "interrupted" || interrupted()) return std::nullopt;
  SequenceRecord record = DescribeRecording(folders, options, name);
  record.name = name;
  record.recipe = RecipeOf(resolved, options);
  record.status = outcome.status;
  record.end_time_s = outcome.end_time_s;
  record.distance_m = outcome.distance_m;
  record.frames = outcome.frames;
  record.renderer = outcome.renderer;
  record.program = ProgramVersion();
  record.frames_fingerprint = FramesFingerprint();
  WriteWholeFile(folders.truth / kRecord, ToJson(record).dump(2) + "\n");
  WriteWholeFile(folders.truth / kChecksums, ChecksumRows({folders.sensors, folders.truth}, unfinished.path()));
  Rename(folders, wanted);
  return record;
}

std::optional<SequenceRecord> FindSequence(const fs::path& folder, const std::string& name) {
  const DatasetFolders folders = DatasetFolders::In(folder, name);
  if (!fs::exists(folders.sensors)) {
    std::error_code ignored;
    fs::remove_all(folders.truth, ignored);
    return std::nullopt;
  }
  const fs::path file = folders.truth / kRecord;
  try {
    return FromJson(nlohmann::json::parse(FindFileContent(file).value_or("")));
  } catch (const nlohmann::json::exception&) {
    throw BadInput(file.string() + ": missing or damaged; remove " + folders.sensors.string() +
                   " to have this sequence recorded again");
  }
}

fs::path SumsOf(const fs::path& folder, const std::string& name) {
  return DatasetFolders::In(folder, name).truth / kChecksums;
}

std::string ChecksumRows(const std::vector<fs::path>& folders, const fs::path& base) {
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::string rows;
  for (const fs::path& file : files) rows += Sha256OfFile(file) + "  " + fs::relative(file, base).string() + "\n";
  return rows;
}

}  // namespace gaitcam
