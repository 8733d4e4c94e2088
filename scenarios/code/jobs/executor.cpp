#include "scenarios/code/jobs/executor.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/runs/interrupt.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/progress.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

fs::path PlanOf(const fs::path& runs, const std::string& hash) { return runs / "plan" / (hash + ".yaml"); }
fs::path LogOf(const fs::path& runs, const std::string& hash) { return runs / "log" / (hash + ".log"); }

ExecutorOptions Absolute(ExecutorOptions options) {
  options.runs = fs::absolute(options.runs);
  if (!options.cache.folder.empty()) options.cache.folder = fs::absolute(options.cache.folder);
  return options;
}

/// Held while an executor works in a folder. @throws BadInput if another process holds it for longer than the kernel
/// needs to release a killed one's.
FileLock LockRuns(const fs::path& runs) {
  for (int i = 0; i < 100; ++i) {
    if (std::optional<FileLock> lock = FileLock::Try(runs / "lock")) return std::move(*lock);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  throw BadInput(runs.string() + ": another gaitcam is at work in this folder");
}

/// The items that are not finished yet, their scenarios written to runs/plan; the others are counted as reused.
std::vector<const WorkItem*> PrepareItems(const std::vector<WorkItem>& items, const ExecutorOptions& options,
                                          ExecutorOutcome& outcome) {
  std::vector<const WorkItem*> todo;
  std::set<std::string> seen;
  for (const WorkItem& item : items) {
    if (!seen.insert(item.hash).second) continue;
    if (item.is_reusable && FindJob(options.runs, item.hash, item.programs)) {
      ++outcome.reused;
      continue;
    }
    fs::remove_all(options.runs / item.hash);
    RemoveUnfinished(options.runs / item.hash);
    WriteWholeFile(PlanOf(options.runs, item.hash), item.scenario_yaml);
    todo.push_back(&item);
  }
  return todo;
}

/// @throws MissingResource.
void MakeRunFolders(const fs::path& runs) {
  for (const char* name : {"plan", "log"}) {
    std::error_code error;
    fs::create_directories(runs / name, error);
    if (error) throw MissingResource("cannot create the folder " + (runs / name).string() + ": " + error.message());
  }
}

/// `gaitcam work` on one item.
PoolTask TaskOf(const WorkItem& item, const ExecutorOptions& options, const fs::path& program) {
  std::vector<std::string> words{program.string(), "work",       options.runs.string(),
                                 item.hash,        "--cache-gb", fmt::format("{}", options.cache.max_gb)};
  if (!options.cache.folder.empty()) words.insert(words.end(), {"--cache", options.cache.folder.string()});
  return {item.hash, words, LogOf(options.runs, item.hash), item.frames_hash};
}

using RunTasks = std::function<bool(const std::vector<PoolTask>&, const PoolOptions&)>;

/// Carries out the unfinished items in a pool and records how each of them ended.
void Execute(const std::vector<WorkItem>& items, const ExecutorOptions& options, const fs::path& program,
             const RunTasks& run, ExecutorOutcome& outcome) {
  std::map<std::string, const WorkItem*> todo;
  std::vector<PoolTask> tasks;
  for (const WorkItem* item : PrepareItems(items, options, outcome)) {
    todo[item->hash] = item;
    tasks.push_back(TaskOf(*item, options, program));
  }
  if (tasks.empty()) return;
  Progress progress(options.what, int64_t(items.size()), options.quiet);
  PoolOptions pool;
  pool.at_once = options.jobs;
  pool.interrupted = options.interrupted;
  pool.on_end = [&](const PoolTask& task, const TaskEnd& end) {
    if (end.kind == TaskEnd::Kind::kKilled) return;
    const bool done = FindJob(options.runs, task.name, todo.at(task.name)->programs).has_value();
    std::error_code ignored;
    if (done) fs::remove(task.log, ignored);
    if (done) {
      ++outcome.done;
    } else {
      outcome.failures[task.name] = end.reason.empty() ? "the process left no result" : end.reason;
    }
    progress.Update(outcome.reused + outcome.done + int64_t(outcome.failures.size()));
  };
  outcome.interrupted = !run(tasks, pool);
  progress.Finish();
}

}  // namespace

WorkItem WorkItemOf(const ResolvedScenario& resolved, const std::string& label, const fs::path& program) {
  return {HashOf(resolved),
          FramesHashOf(resolved),
          resolved.ToYaml(),
          ProgramsFingerprint(resolved.scenario, program),
          label,
          IsFingerprintComplete(resolved.scenario.system)};
}

ExecutorOutcome ExecuteLocally(const std::vector<WorkItem>& items, const ExecutorOptions& given) {
  const ExecutorOptions options = Absolute(given);
  MakeRunFolders(options.runs);
  const FileLock alone = LockRuns(options.runs);
  ExecutorOutcome outcome;
  Execute(items, options, options.program, RunPool, outcome);
  return outcome;
}

ExecutorOutcome ExecuteOnSlurm(const std::vector<WorkItem>& items, const ExecutorOptions& given,
                               const SlurmOptions& slurm) {
  const ExecutorOptions options = Absolute(given);
  MakeRunFolders(options.runs);
  SlurmPool pool(options.runs / "slurm", slurm);
  const FileLock alone = LockRuns(options.runs);
  ExecutorOutcome outcome;
  outcome.interrupted = !pool.WaitForEarlier(options.interrupted);
  if (outcome.interrupted) return outcome;
  std::error_code error;
  const fs::path program =
      fs::canonical(options.program, error);  // on another machine /proc/self/exe is another program
  Execute(
      items, options, error ? options.program : program,
      [&](const auto& tasks, const PoolOptions& more) { return pool.Run(tasks, more); }, outcome);
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
