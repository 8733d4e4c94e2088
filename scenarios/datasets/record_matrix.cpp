#include "scenarios/datasets/record_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <fstream>
#include <iterator>
#include <list>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"
#include "algorithms/io/checksum.h"
#include "scenarios/datasets/dataset_card.h"
#include "scenarios/runs/file_lock.h"
#include "scenarios/runs/interrupt.h"
#include "scenarios/runs/output_folder.h"
#include "scenarios/runs/progress.h"
#include "scenarios/runs/runner.h"
#include "scenarios/runs/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMarker = "matrix.yaml";
constexpr size_t kLongestLevel = 40;

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
  return name.size() <= kLongestLevel ? name : name.substr(0, kLongestLevel - 8) + Sha256(value).substr(0, 8);
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

void CheckConditions(const YamlNode& root, const RecordMatrix& matrix) {
  std::map<std::string, std::string> labels;  // by what they show
  for (const Condition& condition : matrix.experiment.conditions) {
    try {
      CheckPlan(condition.resolved);
    } catch (const BadInput& e) {
      FailAtCondition(root, matrix.options, condition.levels, e.what());
    }
    const auto [it, is_new] = labels.emplace(FramesHashOf(condition.resolved), condition.Label());
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
  if (changes.format) options.recording.format = *changes.format;
  options.recording.pairs.enabled |= changes.pairs;
  options.recording.truth_inside |= changes.truth_inside;
}

/// As it would be typed again.
std::string WordsOf(const MatrixChanges& changes) {
  std::string words;
  for (const std::string& set : changes.sets) words += " --set '" + set + "'";
  if (changes.seed) words += fmt::format(" --seed {}", *changes.seed);
  if (changes.format) words += " --format " + *changes.format;
  if (changes.pairs) words += " --pairs";
  if (changes.truth_inside) words += " --truth-inside";
  return words;
}

void PrepareFolder(const fs::path& out) {
  std::error_code error;
  if (fs::exists(out) && !(fs::is_directory(out) && (fs::is_empty(out, error) || fs::exists(out / kMarker)))) {
    throw BadInput("--out " + out.string() + ": exists and holds something else (no " + kMarker +
                   " in it); name another folder or remove it");
  }
  for (const fs::path& folder : {out / "sequences", WorkFolder(out)}) {
    fs::create_directories(folder, error);
    if (error) throw MissingResource("cannot create the folder " + folder.string() + ": " + error.message());
  }
}

/// What is there already, each the same as would be recorded now.
std::map<std::string, SequenceRecord> FindFinished(const RecordMatrix& matrix, const fs::path& folder) {
  std::map<std::string, SequenceRecord> finished;
  std::set<std::string> wanted;
  for (const PlannedSequence& sequence : matrix.sequences) {
    wanted.insert({sequence.name, sequence.name + "-truth"});
    const std::optional<SequenceRecord> record = FindSequence(folder, sequence.name);
    if (!record) continue;
    if (record->recipe != RecipeOf(matrix.Resolved(sequence), matrix.options.recording)) {
      throw BadInput((folder / sequence.name).string() +
                     ": was recorded from another scenario or with other options; remove it with its truth, or name "
                     "another folder");
    }
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

/// A process that records one sequence, and how far its words say it is.
struct Filming {
  const PlannedSequence* sequence;
  Subprocess process;
  int64_t frames = 0, expected = 0;
};

class Crew {
 public:
  Crew(const RecordMatrix& matrix, const MatrixRecordingOptions& options, MatrixOutcome& outcome)
      : matrix_(matrix), options_(options), outcome_(outcome), folder_(options.out / "sequences") {}
  ~Crew() {
    std::vector<std::string> names;
    for (const Filming& f : filming_) names.push_back(f.sequence->name);
    filming_.clear();  // kills
    for (const std::string& name : names) RemoveUnfinished(folder_ / name);
  }

  size_t size() const { return filming_.size(); }
  void Start(const PlannedSequence& sequence) {
    WriteTextFile(PlanOf(options_.out, sequence.name), matrix_.Resolved(sequence).ToYaml());
    filming_.push_back({&sequence, Subprocess({"/proc/self/exe", "film", options_.out.string(), sequence.name},
                                              LogOf(options_.out, sequence.name))});
  }
  /// Looks after all of them once.
  void Poll() {
    for (auto it = filming_.begin(); it != filming_.end();) {
      const std::optional<Ending> ending = it->process.Poll();
      Listen(*it);
      if (!ending) {
        ++it;
        continue;
      }
      const PlannedSequence* sequence = it->sequence;
      it = filming_.erase(it);
      Judge(*sequence, *ending);
    }
  }
  int64_t frames_done() const {
    int64_t frames = frames_;
    for (const Filming& f : filming_) frames += f.frames;
    return frames;
  }
  /// Of the whole matrix, as far as one knows.
  int64_t frames_expected() const {
    double known = double(frames_), sequences = sequences_;
    for (const Filming& f : filming_) {
      known += double(f.expected);
      sequences += f.expected > 0;
    }
    return sequences > 0 ? std::llround(known / sequences * double(matrix_.sequences.size())) : 0;
  }
  void Count(const SequenceRecord& record) {
    frames_ += record.frames;
    ++sequences_;
  }

 private:
  void Listen(Filming& filming) const {
    const std::string said = LastLine(LogOf(options_.out, filming.sequence->name));
    long long frames = 0, expected = 0;
    if (std::sscanf(said.c_str(), "frame %lld of %lld", &frames, &expected) != 2) return;
    filming.frames = frames;
    filming.expected = std::max(frames, expected);
  }
  void Judge(const PlannedSequence& sequence, const Ending& ending) {
    RemoveUnfinished(folder_ / sequence.name);
    if (ending.ok()) {
      const std::optional<SequenceRecord> record = FindSequence(folder_, sequence.name);
      GAITCAM_ASSERT(record);
      Count(*record);
      return;
    }
    std::string said = LastLine(LogOf(options_.out, sequence.name));
    const std::string prefix = "gaitcam: ";
    if (said.starts_with(prefix)) said = said.substr(prefix.size());
    if (ending.code == 4) throw MissingResource(said);
    outcome_.failures[sequence.name] = ending.signal != 0 ? "the process " + ending.ToText() : said;
  }

  const RecordMatrix& matrix_;
  const MatrixRecordingOptions& options_;
  MatrixOutcome& outcome_;
  fs::path folder_;
  std::list<Filming> filming_;
  int64_t frames_ = 0;
  double sequences_ = 0;
};

void RecordMissing(const RecordMatrix& matrix, const MatrixRecordingOptions& options,
                   const std::map<std::string, SequenceRecord>& finished, MatrixOutcome& outcome) {
  const size_t at_once = size_t(options.jobs > 0 ? options.jobs : std::max(1u, std::thread::hardware_concurrency()));
  YAML::Emitter yaml;
  WriteYaml(yaml, matrix.options.recording);
  WriteTextFile(OptionsOf(options.out), std::string(yaml.c_str()) + "\n");
  Crew crew(matrix, options, outcome);
  Progress progress(fmt::format("{} ({} sequences)", matrix.experiment.options.name, matrix.sequences.size()), 0,
                    options.quiet);
  for (const auto& [name, record] : finished) crew.Count(record);
  auto next = matrix.sequences.begin();
  while (next != matrix.sequences.end() || crew.size() > 0) {
    if (options.interrupted()) {
      outcome.interrupted = true;
      break;
    }
    for (; next != matrix.sequences.end() && crew.size() < at_once; ++next) {
      if (finished.count(next->name) == 0) crew.Start(*next);
    }
    crew.Poll();
    progress.Update(crew.frames_done(), crew.frames_expected());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  progress.Finish();
}

}  // namespace

bool IsMatrix(const fs::path& file) { return YamlNode::LoadFile(file).Has("base"); }

ResolvedScenario RecordMatrix::Resolved(const PlannedSequence& sequence) const {
  return experiment.conditions[sequence.condition].WithSeed(sequence.seed);
}

RecordMatrix ReadMatrix(const fs::path& file, const MatrixChanges& changes, bool yes) {
  const YamlNode root = YamlNode::LoadFile(file);
  RecordMatrix matrix;
  ReadYaml(root, matrix.options);
  ApplyChanges(changes, matrix.options);
  matrix.experiment = ResolveExperiment(root, matrix.options, yes);
  CheckConditions(root, matrix);
  matrix.sequences = PlanSequences(matrix.experiment);
  std::ifstream stream(file, std::ios::binary);
  matrix.changes = WordsOf(changes);
  matrix.text.assign(std::istreambuf_iterator<char>(stream), {});
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
  WriteTextFile(options.out / kMarker, matrix.text);
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
  ReadYaml(YamlNode::LoadFile(OptionsOf(out)), options);
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
