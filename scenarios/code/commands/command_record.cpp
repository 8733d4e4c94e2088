#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "algorithms/core/errors.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/datasets/record_matrix.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/recorder.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

SequenceOptions OptionsOf(const RecordArguments& arguments) {
  SequenceOptions options;
  if (arguments.format) options.format = DatasetFormatFromText(*arguments.format);
  options.truth_inside = arguments.truth_inside;
  options.preview = arguments.preview;
  if (arguments.compression) options.compression = *arguments.compression;
  options.pairs.enabled = arguments.pairs;
  return options;
}

/// Removes the recording if its pairs and pictures cannot be written.
SequenceRecord DescribeOrRemove(const DatasetFolders& folders, const SequenceOptions& options,
                                const std::string& title) {
  try {
    return DescribeRecording(folders, options, title);
  } catch (...) {
    RemoveRecording(folders);
    throw;
  }
}

/// Recordings lie beside each other in a folder; in one that holds other things only, nothing is written.
void RefuseStrangersFolder(const fs::path& out) {
  if (!fs::exists(out)) return;
  if (!fs::is_directory(out)) throw BadInput("--out " + out.string() + ": this is a file; expected a folder's name");
  bool is_empty = true;
  for (const auto& item : fs::directory_iterator(out)) {
    const std::string name = item.path().filename().string();
    if (name.ends_with("-truth")) return;
    is_empty = is_empty && name.starts_with('.');
  }
  if (!is_empty) {
    throw BadInput("--out " + out.string() +
                   ": exists and holds something else (no recording in it); name another folder or remove it");
  }
}

/// One scenario into OUT/NAME and OUT/NAME-truth. Frames recorded before Ctrl-C are kept.
int RecordOne(const RecordArguments& arguments, const CommonOptions& common) {
  const ResolvedScenario resolved = ReadScenario(arguments.scenario.file, arguments.scenario.Assignments());
  const Scenario& scenario = resolved.scenario;
  const InterruptGuard guard;
  const SequenceOptions sequence = OptionsOf(arguments);
  RecordOptions options;
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  options.format = sequence.WriterOptions();
  fs::path out = arguments.out;
  if (out.empty()) out = fmt::format("datasets/{}-seed{}", scenario.name, scenario.seed);
  RefuseStrangersFolder(out);
  const RecordOutcome outcome = RecordScenario(resolved, DatasetFolders::In(out, scenario.name), options);
  const SequenceRecord record = DescribeOrRemove(outcome.folders, sequence, scenario.name);
  if (common.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"sensors", outcome.folders.sensors.string()},
                                              {"truth", outcome.folders.truth.string()},
                                              {"status", outcome.status},
                                              {"end_time_s", outcome.end_time_s},
                                              {"frames", outcome.frames},
                                              {"pairs", record.pairs},
                                              {"blur_median_px", record.blur_median_px}}
                           .dump(2));
  } else if (!common.quiet) {
    fmt::print("{} frames{}; the walk {} at {:.2f} s; blur {:.1f} px (90 % of the frames: up to {:.1f})\n",
               outcome.frames, record.pairs > 0 ? fmt::format(", {} pairs", record.pairs) : "",
               outcome.status == "interrupted" ? "was interrupted" : outcome.status, outcome.end_time_s,
               record.blur_median_px, record.blur_p90_px);
    fmt::print("sensors: {}\ntruth:   {}\n", outcome.folders.sensors.string(), outcome.folders.truth.string());
  }
  return outcome.status == "interrupted" ? 130 : 0;
}

void PrintOutcome(const MatrixOutcome& outcome, const RecordMatrix& matrix, const fs::path& out) {
  int64_t frames = 0;
  for (const SequenceRecord& r : outcome.records) {
    frames += r.frames;
    fmt::print("{:<44} {:>5} frames {:>7.2f} s  blur {:>5.1f} / {:>5.1f} px  {}\n", r.name, r.frames, r.end_time_s,
               r.blur_median_px, r.blur_p90_px, r.status);
  }
  fmt::print("{} of {} sequences ({} were there), {} frames: {}\n", outcome.records.size(), matrix.sequences.size(),
             outcome.reused, frames, out.string());
}

nlohmann::ordered_json ToJson(const MatrixOutcome& outcome, const RecordMatrix& matrix, const fs::path& out) {
  nlohmann::ordered_json json{{"dataset", out.string()},
                              {"wanted", matrix.sequences.size()},
                              {"recorded", outcome.records.size()},
                              {"reused", outcome.reused},
                              {"interrupted", outcome.interrupted},
                              {"failures", outcome.failures},
                              {"sequences", nlohmann::ordered_json::array()}};
  for (const SequenceRecord& r : outcome.records) {
    json["sequences"].push_back({{"name", r.name},
                                 {"status", r.status},
                                 {"frames", r.frames},
                                 {"end_time_s", r.end_time_s},
                                 {"pairs", r.pairs},
                                 {"blur_median_px", r.blur_median_px},
                                 {"blur_p90_px", r.blur_p90_px}});
  }
  return json;
}

int RecordMany(const RecordArguments& arguments, const CommonOptions& common) {
  MatrixChanges changes;
  changes.sets = arguments.scenario.sets;
  if (arguments.scenario.system) changes.sets.push_back("system=" + *arguments.scenario.system);
  changes.seed = arguments.scenario.seed;
  changes.format = arguments.format;
  changes.compression = arguments.compression;
  changes.pairs = arguments.pairs;
  changes.truth_inside = arguments.truth_inside;
  const RecordMatrix matrix = ReadMatrix(arguments.scenario.file, changes, arguments.yes);
  const InterruptGuard guard;
  MatrixRecordingOptions options;
  options.out = arguments.out.empty() ? fs::path("datasets") / matrix.experiment.options.name : arguments.out;
  options.jobs = arguments.jobs;
  options.quiet = common.quiet;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  const MatrixOutcome outcome = RecordDataset(matrix, options);
  if (common.json) {
    fmt::print("{}\n", ToJson(outcome, matrix, options.out).dump(2));
  } else if (!common.quiet) {
    PrintOutcome(outcome, matrix, options.out);
  }
  for (const auto& [name, why] : outcome.failures) fmt::print(stderr, "gaitcam: {}: {}\n", name, why);
  if (outcome.interrupted) return 130;
  return outcome.failures.empty() ? 0 : 2;
}

}  // namespace

int RecordCommand(const RecordArguments& arguments, const CommonOptions& common) {
  return IsMatrix(arguments.scenario.file) ? RecordMany(arguments, common) : RecordOne(arguments, common);
}

int FilmCommand(const FilmArguments& arguments, const CommonOptions&) {
  return FilmSequence(arguments.dataset, arguments.name);
}

}  // namespace gaitcam
