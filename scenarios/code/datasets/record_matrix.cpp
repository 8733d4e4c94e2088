#include "scenarios/code/datasets/record_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <iterator>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/whole_file.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/datasets/dataset_card.h"
#include "scenarios/code/jobs/pool.h"
#include "scenarios/code/runs/file_lock.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMarker = "matrix.yaml";
constexpr size_t kMaxLevelLength = 40;

fs::path WorkFolder(const fs::path& out) { return out / ".work"; }
fs::path PlanOf(const fs::path& out, const std::string& name) { return WorkFolder(out) / (name + ".yaml"); }
fs::path LogOf(const fs::path& out, const std::string& name) { return WorkFolder(out) / (name + ".log"); }
fs::path OptionsOf(const fs::path& out) { return WorkFolder(out) / "options"; }

/// "brisk", "exposure_ms20": what a level adds to a sequence's name.
std::string LevelName(const std::string& key, const std::string& value) {
  const bool number =
      !value.empty() && (std::isdigit(static_cast<unsigned char>(value[0])) != 0 || value[0] == '-' || value[0] == '.');
  std::string name = number || value == "true" || value == "false" || value == "~" ? ShortKey(key) + value : value;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '_') c = '_';
  }
  return name.size() <= kMaxLevelLength ? name : name.substr(0, kMaxLevelLength - 8) + Sha256(value).substr(0, 8);
}

std::vector<PlannedSequence> PlanSequences(const Experiment& experiment) {
  std::vector<PlannedSequence> sequences;
  std::set<std::string> taken;
  for (size_t c = 0; c < experiment.conditions.size(); ++c) {
    for (const uint64_t seed : experiment.options.seeds) {
      std::string name;
      for (const auto& [key, value] : experiment.conditions[c].levels) name += LevelName(key, value) + "-";
      name += fmt::format("seed{}", seed);
      if (name[0] == '.') name = "_" + name;
      if (!taken.insert(name).second) taken.insert(name += fmt::format("-{}", c + 1));
      sequences.push_back({name, c, seed});
    }
  }
  return sequences;
}

void CheckConditions(const OptionValue& root, const RecordMatrix& matrix) {
  std::map<std::string, std::string> labels;  // by the hash of their frames and who is to render them
  for (const Condition& condition : matrix.experiment.conditions) {
    try {
      CheckPlan(condition.resolved);
    } catch (const BadInput& e) {
      FailAtCondition(root, matrix.options, condition.levels, e.what());
    }
    const std::string films = FramesHashOf(condition.resolved) + condition.resolved.scenario.camera.renderer.ToText();
    const auto [it, is_new] = labels.emplace(films, condition.Label());
    if (!is_new) root.Fail("the conditions \"" + it->second + "\" and \"" + condition.Label() + "\" film the same");
  }
}

void ApplyChanges(const MatrixChanges& changes, MatrixOptions& options) {
  for (const std::string& set : changes.sets) {
    const size_t at = set.find('=');
    if (at == std::string::npos || at == 0) throw BadInput("--set " + set + ": expected key=value");
    options.set.emplace_back(set.substr(0, at), set.substr(at + 1));
  }
  if (changes.seed) options.seeds.assign(1, *changes.seed);
  if (changes.format) options.recording.format = DatasetFormatFromText(*changes.format);
  if (changes.compression) options.recording.compression = *changes.compression;
  options.recording.pairs.enabled |= changes.pairs;
  options.recording.truth_inside |= changes.truth_inside;
}

/// The changes as options of a command line.
std::string WordsOf(const MatrixChanges& changes) {
  std::string words;
  for (const std::string& set : changes.sets) words += " --set '" + set + "'";
  if (changes.seed) words += fmt::format(" --seed {}", *changes.seed);
  if (changes.format) words += " --format " + *changes.format;
  if (changes.compression) words += fmt::format(" --compression {}", *changes.compression);
  if (changes.pairs) words += " --pairs";
  if (changes.truth_inside) words += " --truth-inside";
  return words;
}

void PrepareFolder(const fs::path& out) {
  std::error_code error;
  // A process that was killed early has left the second alone.
  const auto is_ours = [&] { return fs::exists(out / kMarker) || fs::exists(WorkFolder(out)); };
  if (fs::exists(out) && !(fs::is_directory(out) && (fs::is_empty(out, error) || is_ours()))) {
    throw BadInput("--out " + out.string() + ": exists and holds something else (no " + kMarker +
                   " in it); name another folder or remove it");
  }
  for (const fs::path& folder : {WorkFolder(out), out / "sequences"}) {
    fs::create_directories(folder, error);
    if (error) throw MissingResource("cannot create the folder " + folder.string() + ": " + error.message());
  }
}

/// The finished sequences. @throws BadInput if one was recorded from something else.
std::map<std::string, SequenceRecord> FindFinished(const RecordMatrix& matrix, const fs::path& folder) {
  std::map<std::string, SequenceRecord> finished;
  std::set<std::string> wanted;
  for (const PlannedSequence& sequence : matrix.sequences) {
    wanted.insert({sequence.name, sequence.name + "-truth"});
    const std::optional<SequenceRecord> record = FindSequence(folder, sequence.name);
    if (!record) continue;
    const ResolvedScenario resolved = matrix.Resolved(sequence);
    const auto refuse = [&](const std::string& why) {
      throw BadInput((folder / sequence.name).string() + ": was " + why +
                     "; remove it with its truth, or name another folder");
    };
    if (record->recipe != RecipeOf(resolved, matrix.options.recording))
      refuse("recorded from another scenario or with other options");
    const RendererChoice& choice = resolved.scenario.camera.renderer;
    if (!choice.Permits(record->renderer.is_software))
      refuse(fmt::format("rendered by {}, which camera.renderer = {} rules out", record->renderer.ToText(),
                         choice.ToText()));
    finished[sequence.name] = *record;
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name[0] != '.' && wanted.count(name) == 0) {
      throw BadInput(entry.path().string() + ": is none of this matrix's sequences; name another folder or remove it");
    }
  }
  return finished;
}

/// Frames of the sequences that are recorded, and of those that are being recorded, as their logs say.
class FrameCount {
 public:
  explicit FrameCount(const RecordMatrix& matrix) : all_(matrix.sequences.size()) {}

  void AddFinished(const SequenceRecord& record) {
    finished_ += record.frames;
    ++sequences_;
  }
  void Show(const std::vector<const PoolTask*>& running, Progress& progress) const {
    int64_t done = finished_;
    double known = double(finished_), sequences = sequences_;
    for (const PoolTask* task : running) {
      long long frames = 0, expected = 0;
      if (std::sscanf(LastLine(task->log).c_str(), "frame %lld of %lld", &frames, &expected) != 2) continue;
      done += frames;
      known += double(std::max(frames, expected));
      sequences += expected > 0;
    }
    progress.Update(done, sequences > 0 ? std::llround(known / sequences * double(all_)) : 0);
  }

 private:
  const size_t all_;
  int64_t finished_ = 0;
  double sequences_ = 0;
};

void RecordMissing(const RecordMatrix& matrix, const MatrixRecordingOptions& options,
                   const std::map<std::string, SequenceRecord>& finished, MatrixOutcome& outcome) {
  YAML::Emitter yaml;
  WriteYaml(yaml, matrix.options.recording);
  WriteWholeFile(OptionsOf(options.out), std::string(yaml.c_str()) + "\n");
  std::vector<PoolTask> tasks;
  std::map<std::string, const PlannedSequence*> planned;
  for (const PlannedSequence& sequence : matrix.sequences) {
    if (finished.count(sequence.name) > 0) continue;
    tasks.push_back({sequence.name,
                     {"/proc/self/exe", "film", options.out.string(), sequence.name},
                     LogOf(options.out, sequence.name)});
    planned[sequence.name] = &sequence;
  }
  const fs::path folder = options.out / "sequences";
  FrameCount count(matrix);
  for (const auto& [name, record] : finished) count.AddFinished(record);
  Progress progress(fmt::format("{} ({} sequences)", matrix.experiment.options.name, matrix.sequences.size()), 0,
                    options.quiet);
  PoolOptions pool;
  pool.at_once = options.jobs;
  pool.interrupted = options.interrupted;
  pool.on_start = [&](const PoolTask& task) {
    WriteWholeFile(PlanOf(options.out, task.name), matrix.Resolved(*planned.at(task.name)).ToYaml());
  };
  pool.on_poll = [&](const std::vector<const PoolTask*>& running) { count.Show(running, progress); };
  pool.on_end = [&](const PoolTask& task, const TaskEnd& end) {
    RemoveUnfinished(folder / task.name);
    if (end.kind == TaskEnd::Kind::kFailed) outcome.failures[task.name] = end.reason;
    if (end.kind == TaskEnd::Kind::kDone) count.AddFinished(FindSequence(folder, task.name).value());
  };
  outcome.interrupted = !RunPool(tasks, pool);
  count.Show({}, progress);
  progress.Finish();
}

}  // namespace

bool IsMatrix(const fs::path& file) { return LoadYaml(file).Has("base"); }

ResolvedScenario RecordMatrix::Resolved(const PlannedSequence& sequence) const {
  return experiment.conditions[sequence.condition].WithSeed(sequence.seed);
}

RecordMatrix ReadMatrix(const fs::path& file, const MatrixChanges& changes, bool yes) {
  const OptionValue root = LoadYaml(file);
  RecordMatrix matrix;
  ReadOption(root, matrix.options);
  ApplyChanges(changes, matrix.options);
  matrix.experiment = ResolveExperiment(root, matrix.options, yes);
  CheckConditions(root, matrix);
  matrix.sequences = PlanSequences(matrix.experiment);
  matrix.changes = WordsOf(changes);
  matrix.text = FileContent(file);
  return matrix;
}

MatrixOutcome RecordDataset(const RecordMatrix& matrix, const MatrixRecordingOptions& given) {
  MatrixRecordingOptions options = given;
  options.out = fs::absolute(given.out).lexically_normal();
  PrepareFolder(options.out);
  MatrixOutcome outcome;
  const std::optional<FileLock> alone = FileLock::Try(WorkFolder(options.out) / "lock");
  if (!alone) throw BadInput(options.out.string() + ": another process records into this folder");
  const std::map<std::string, SequenceRecord> finished = FindFinished(matrix, options.out / "sequences");
  WriteWholeFile(options.out / kMarker, matrix.text);
  outcome.reused = int(finished.size());
  if (finished.size() < matrix.sequences.size()) RecordMissing(matrix, options, finished, outcome);
  for (const PlannedSequence& sequence : matrix.sequences) {
    if (const auto record = FindSequence(options.out / "sequences", sequence.name)) outcome.records.push_back(*record);
  }
  WriteDatasetFiles(options.out, matrix, outcome.records);
  std::error_code ignored;
  if (outcome.records.size() == matrix.sequences.size()) fs::remove_all(WorkFolder(options.out), ignored);
  return outcome;
}

int FilmSequence(const fs::path& out, const std::string& name) {
  const ResolvedScenario resolved = ReadScenario(PlanOf(out, name), {});
  SequenceOptions options;
  ReadOption(LoadYaml(OptionsOf(out)), options);
  const InterruptGuard guard;
  auto last = std::chrono::steady_clock::now();
  const auto progress = [&](int64_t frames, int64_t expected) {
    const auto now = std::chrono::steady_clock::now();
    if (frames > 1 && now - last < std::chrono::milliseconds(300)) return;
    last = now;
    fmt::print("frame {} of {}\n", frames, expected);
    std::fflush(stdout);
  };
  const auto record =
      RecordSequence(resolved, out / "sequences", name, options, progress, [&] { return guard.Interrupted(); });
  return record ? 0 : 130;
}

}  // namespace gaitcam
