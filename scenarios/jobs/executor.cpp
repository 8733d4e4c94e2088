#include "scenarios/jobs/executor.h"

#include <fmt/format.h>

#include <deque>
#include <list>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"
#include "scenarios/runs/interrupt.h"
#include "scenarios/runs/output_folder.h"
#include "scenarios/runs/progress.h"
#include "scenarios/runs/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

fs::path PlanOf(const fs::path& runs, const std::string& hash) { return runs / "plan" / (hash + ".yaml"); }
fs::path LogOf(const fs::path& runs, const std::string& hash) { return runs / "log" / (hash + ".log"); }

/// Starts `gaitcam work` on one item, its words going to its log.
Subprocess StartWorker(const WorkItem& item, const ExecutorOptions& options) {
  std::vector<std::string> words{options.program.string(),
                                 "work",
                                 options.runs.string(),
                                 item.hash,
                                 "--cache-gb",
                                 fmt::format("{}", options.cache.max_gb)};
  if (!options.cache.folder.empty()) words.insert(words.end(), {"--cache", options.cache.folder.string()});
  return Subprocess(words, LogOf(options.runs, item.hash));
}

/// What waits, what runs, and which frames are being recorded.
class Schedule {
 public:
  explicit Schedule(std::vector<const WorkItem*> items) : waiting_(items.begin(), items.end()) {}

  /// The first item whose frames nobody is recording just now; null if there is none.
  const WorkItem* Next() {
    for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
      const WorkItem* item = *it;
      const bool recorded = recorded_.count(item->frames_hash) > 0;
      if (!recorded && !recording_.insert(item->frames_hash).second) continue;
      waiting_.erase(it);
      return item;
    }
    return nullptr;
  }
  void Done(const WorkItem& item, bool ok) {
    recording_.erase(item.frames_hash);
    if (ok) recorded_.insert(item.frames_hash);
  }
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<const WorkItem*> waiting_;
  std::set<std::string> recorded_, recording_;
};

/// The processes in flight; they are killed if it is left before they end.
class Crew {
 public:
  Crew(const ExecutorOptions& options, ExecutorOutcome& outcome) : options_(options), outcome_(outcome) {}

  size_t size() const { return running_.size(); }
  void Start(const WorkItem& item) { running_.push_back({StartWorker(item, options_), &item}); }

  /// @returns an item whose process has ended, or null after a moment's wait.
  const WorkItem* Reap(bool& ok) {
    for (auto it = running_.begin(); it != running_.end(); ++it) {
      const std::optional<Ending> ending = it->process.Poll();
      if (!ending) continue;
      const WorkItem* item = it->item;
      running_.erase(it);
      ok = ending->ok();
      Judge(*item, *ending);
      return item;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return nullptr;
  }

 private:
  struct Member {
    Subprocess process;
    const WorkItem* item;
  };

  void Judge(const WorkItem& item, const Ending& ending) {
    const fs::path log = LogOf(options_.runs, item.hash);
    if (ending.ok()) {
      std::error_code ignored;
      fs::remove(log, ignored);
      ++outcome_.done;
      return;
    }
    const std::string said = LastLine(log), prefix = "gaitcam: ";
    const std::string line = said.starts_with(prefix) ? said.substr(prefix.size()) : said;
    if (ending.code == 4) throw MissingResource(line);
    outcome_.failures[item.hash] = ending.signal != 0 || line.empty() ? "the run " + ending.ToText() : line;
  }

  const ExecutorOptions& options_;
  ExecutorOutcome& outcome_;
  std::list<Member> running_;
};

}  // namespace

namespace internal {

ExecutorOptions Absolute(ExecutorOptions options) {
  options.runs = fs::absolute(options.runs);
  if (!options.cache.folder.empty()) options.cache.folder = fs::absolute(options.cache.folder);
  return options;
}

FileLock LockRuns(const fs::path& runs) {
  for (int i = 0; i < 100; ++i) {
    if (std::optional<FileLock> lock = FileLock::Try(runs / "lock")) return std::move(*lock);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  throw BadInput(runs.string() + ": another gaitcam is at work in this folder");
}

std::vector<const WorkItem*> PrepareItems(const std::vector<WorkItem>& items, const ExecutorOptions& options,
                                          ExecutorOutcome& outcome) {
  std::vector<const WorkItem*> todo;
  std::set<std::string> seen;
  for (const WorkItem& item : items) {
    if (!seen.insert(item.hash).second) continue;
    if (FindJob(options.runs, item.hash, item.programs)) {
      ++outcome.reused;
      continue;
    }
    RemoveUnfinished(options.runs / item.hash);
    WriteTextFile(PlanOf(options.runs, item.hash), item.scenario_yaml);
    todo.push_back(&item);
  }
  return todo;
}

void MakeRunFolders(const fs::path& runs) {
  for (const char* name : {"plan", "log"}) {
    std::error_code error;
    fs::create_directories(runs / name, error);
    if (error) throw MissingResource("cannot create the folder " + (runs / name).string() + ": " + error.message());
  }
}

}  // namespace internal

WorkItem WorkItemOf(const ResolvedScenario& resolved, const std::string& label, const fs::path& program) {
  return {HashOf(resolved), FramesHashOf(resolved), resolved.ToYaml(), ProgramsFingerprint(resolved.scenario, program),
          label};
}

ExecutorOutcome ExecuteLocally(const std::vector<WorkItem>& items, const ExecutorOptions& given) {
  const ExecutorOptions options = internal::Absolute(given);
  internal::MakeRunFolders(options.runs);
  const FileLock alone = internal::LockRuns(options.runs);
  ExecutorOutcome outcome;
  Schedule schedule(internal::PrepareItems(items, options, outcome));
  const size_t at_once = size_t(options.jobs > 0 ? options.jobs : std::max(1u, std::thread::hardware_concurrency()));
  Progress progress(options.what, int64_t(items.size()), options.quiet);
  Crew crew(options, outcome);
  int64_t ended = outcome.reused;
  while (!schedule.empty() || crew.size() > 0) {
    if (options.interrupted()) {
      outcome.interrupted = true;
      break;
    }
    while (crew.size() < at_once) {
      const WorkItem* item = schedule.Next();
      if (item == nullptr) break;
      crew.Start(*item);
    }
    bool ok = false;
    if (const WorkItem* item = crew.Reap(ok)) {
      schedule.Done(*item, ok);
      progress.Update(++ended);
    }
  }
  progress.Finish();
  return outcome;
}

int WorkOn(const fs::path& runs, const std::string& hash, const SequenceCacheOptions& cache) {
  const ResolvedScenario resolved = ReadScenario(PlanOf(runs, hash), {});
  GAITCAM_ASSERT(HashOf(resolved) == hash);
  const InterruptGuard guard;
  JobOptions options;
  options.runs = runs;
  options.cache = cache;
  options.interrupted = [&guard] { return guard.Interrupted(); };
  return RunJob(resolved, options) ? 0 : 130;
}

}  // namespace gaitcam
