#include "scenarios/code/jobs/slurm_pool.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr int kMaxArrayTasks = 1000;   // Slurm's own limit (MaxArraySize) unless an administrator raised it
constexpr int kMaxSilentAnswers = 60;  // of a controller that may be restarting

/// A word as a shell takes it.
std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// Where an array's task leaves a command's exit code.
fs::path CodeOf(const PoolTask& task) { return task.log.string() + ".code"; }

/// The first task of each resource comes first: the others would only wait for what it makes.
std::vector<const PoolTask*> MakersFirst(const std::vector<PoolTask>& tasks) {
  std::vector<const PoolTask*> ordered;
  std::set<std::string> seen;
  std::set<const PoolTask*> makers;
  for (const PoolTask& task : tasks) {
    ordered.push_back(&task);
    if (!task.resource.empty() && seen.insert(task.resource).second) makers.insert(&task);
  }
  std::stable_partition(ordered.begin(), ordered.end(), [&](const PoolTask* task) { return makers.count(task) > 0; });
  return ordered;
}

/// One line per command: its log, a tab, and its words as a shell takes them.
std::string CommandList(const std::vector<const PoolTask*>& tasks) {
  std::string list;
  for (const PoolTask* task : tasks) {
    list += task->log.string() + "\t";
    for (const std::string& word : task->command) list += Quoted(word) + " ";
    list += "\n";
  }
  return list;
}

/// An array's task runs every `count`-th command of the list, each in a process of its own.
std::string BatchScript(const fs::path& folder, int count) {
  return fmt::format(
      "#!/bin/sh\n# A task of a gaitcam job array: every {0}th command of the list, from its own number on.\n"
      "export GAITCAM_DATA={1}\ncd {2} || exit 4\n"
      "awk -v task=\"$SLURM_ARRAY_TASK_ID\" '(NR - 1) % {0} == task' list | while IFS='\t' read -r log command; do\n"
      "  (eval \"$command\") >\"$log\" 2>&1 </dev/null\n  echo $? >\"$log.code\"\ndone\n",
      count, Quoted(DataFolder().string()), Quoted(folder.string()));
}

/// How the command of a task ended, if it has.
std::optional<Ending> FindEnding(const PoolTask& task) {
  int code = 0;
  if (!(std::ifstream(CodeOf(task)) >> code)) return std::nullopt;
  return code > 128 ? Ending{-1, code - 128} : Ending{code, 0};
}

/// Tasks of a submitted job, reported as they end.
class PendingTasks {
 public:
  PendingTasks(std::vector<const PoolTask*> tasks, const PoolOptions& options)
      : pending_(std::move(tasks)), options_(options) {}

  /// Reports those that have left an exit code. @throws MissingResource.
  void Collect() {
    std::erase_if(pending_, [&](const PoolTask* task) {
      const std::optional<Ending> ending = FindEnding(*task);
      if (!ending) return false;
      End(*task, TaskEndOf(*ending, task->log));
      return true;
    });
    options_.on_poll(pending_);
  }
  const std::vector<const PoolTask*>& pending() const { return pending_; }
  void End(const PoolTask& task, const TaskEnd& end) const {
    std::error_code ignored;
    fs::remove(CodeOf(task), ignored);
    options_.on_end(task, end);
  }

 private:
  std::vector<const PoolTask*> pending_;
  const PoolOptions& options_;
};

}  // namespace

void CheckSlurm() {
  for (const char* program : {"sbatch", "squeue", "scancel"}) {
    if (FindProgram(program)) continue;
    throw MissingResource(fmt::format(
        "there is no {} on this machine; install Slurm (Debian: slurm-client), or leave out --executor slurm",
        program));
  }
}

SlurmPool::SlurmPool(fs::path folder, SlurmOptions options)
    : folder_(fs::absolute(folder)), options_(std::move(options)) {
  CheckSlurm();
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw MissingResource("cannot create the folder " + folder_.string() + ": " + error.message());
  if (const std::optional<std::string> job = FindFileContent(folder_ / "job"))
    number_ = job->substr(0, job->find('\n'));
}

SlurmPool::Answer SlurmPool::Ask(const std::vector<std::string>& words) const {
  Subprocess process(words, folder_ / "said");
  const std::optional<Ending> ending = process.Wait(60);
  return {ending ? *ending : Ending{-1, 0}, FindFileContent(folder_ / "said").value_or("")};
}

void SlurmPool::Submit(int count, int at_once) {
  std::vector<std::string> words{
      "sbatch", "--parsable", "--job-name=" + options_.job_name,
      fmt::format("--array=0-{}{}", count - 1, at_once > 0 ? fmt::format("%{}", at_once) : std::string()),
      "--output=" + (folder_ / "task-%A_%a.txt").string()};
  words.insert(words.end(), options_.sbatch.begin(), options_.sbatch.end());
  words.push_back((folder_ / "array.sh").string());
  const Answer answer = Ask(words);
  number_ = answer.text.substr(0, answer.text.find_first_of(";\n"));  // "12;cluster"
  if (!answer.ending.ok() || number_.empty() || number_.find_first_not_of("0123456789") != std::string::npos)
    throw MissingResource("Slurm does not take the job: " + LastLine(folder_ / "said"));
  WriteWholeFile(folder_ / "job", number_ + "\n");
}

/// Whether a task of the job waits or runs.
bool SlurmPool::Active() {
  if (number_.empty()) return false;
  const Answer answer = Ask({"squeue", "--noheader", "--jobs=" + number_, "--format=%T"});
  const bool unknown = answer.text.find("Invalid job id") != std::string::npos;  // ended a while ago
  if (answer.ending.ok() || unknown) {
    silent_ = 0;
    return !unknown && answer.text.find_first_not_of(" \n") != std::string::npos;
  }
  if (++silent_ > kMaxSilentAnswers) throw MissingResource("Slurm does not answer: " + LastLine(folder_ / "said"));
  return true;
}

void SlurmPool::Cancel() const {
  if (!number_.empty()) Ask({"scancel", number_});
}

/// Until no task of the job waits or runs. @returns false if interrupted; the job is cancelled then.
bool SlurmPool::Wait(const std::function<bool()>& interrupted, const std::function<void()>& watch) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  while (Active()) {
    watch();
    const double poll_s = (Clock::now() - start < std::chrono::seconds(30) ? 1 : 5) * options_.poll_s;
    const auto next = Clock::now() + std::chrono::duration<double>(poll_s);
    while (Clock::now() < next) {
      if (interrupted()) {
        Cancel();
        if (!options_.quiet) fmt::print(stderr, "\ngaitcam: cancelled Slurm job {}\n", number_);
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
  watch();
  return true;
}

bool SlurmPool::WaitForEarlier(const std::function<bool()>& interrupted) {
  if (!Active()) return true;
  if (!options_.quiet) fmt::print(stderr, "gaitcam: waiting for Slurm job {} of an earlier call\n", number_);
  return Wait(interrupted, [] {});
}

bool SlurmPool::Run(const std::vector<PoolTask>& tasks, const PoolOptions& options) {
  if (tasks.empty()) return true;
  const std::vector<const PoolTask*> ordered = MakersFirst(tasks);
  const int count = int(std::min<size_t>(ordered.size(), kMaxArrayTasks));
  for (const PoolTask* task : ordered) {
    options.on_start(*task);
    std::error_code ignored;
    for (const fs::path& file : {task->log, CodeOf(*task)}) fs::remove(file, ignored);
  }
  WriteWholeFile(folder_ / "list", CommandList(ordered));
  WriteWholeFile(folder_ / "array.sh", BatchScript(folder_, count));
  Submit(count, options.at_once);
  PendingTasks pending(ordered, options);
  try {
    if (!Wait(options.interrupted, [&] { pending.Collect(); })) {
      for (const PoolTask* task : pending.pending()) pending.End(*task, {TaskEnd::Kind::kKilled, "cancelled"});
      return false;
    }
  } catch (const MissingResource&) {
    Cancel();
    throw;
  }
  std::error_code ignored;
  fs::remove(folder_ / "job", ignored);  // it has ended: no later call need wait for it
  for (size_t i = 0; i < ordered.size(); ++i) {
    const bool ended =
        std::find(pending.pending().begin(), pending.pending().end(), ordered[i]) == pending.pending().end();
    if (!ended) pending.End(*ordered[i], {TaskEnd::Kind::kFailed, WhyTaskEnded(int(i) % count)});
  }
  return true;
}

/// Why an array's task left commands undone, as far as Slurm says it.
std::string SlurmPool::WhyTaskEnded(int array_task) const {
  const std::string said = LastLine(folder_ / fmt::format("task-{}_{}.txt", number_, array_task));
  if (!said.empty()) return said;
  const Answer answer = Ask({"scontrol", "--oneliner", "show", "job", fmt::format("{}_{}", number_, array_task)});
  const size_t at = answer.text.find("JobState=");
  if (at == std::string::npos) return "its Slurm task did not run it";
  return "its Slurm task ended: " + answer.text.substr(at + 9, answer.text.find(' ', at) - at - 9);
}

}  // namespace gaitcam
