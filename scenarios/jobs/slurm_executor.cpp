#include "scenarios/jobs/slurm_executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "algorithms/core/errors.h"
#include "scenarios/folders.h"
#include "scenarios/runs/output_folder.h"
#include "scenarios/runs/progress.h"
#include "scenarios/runs/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr int kMostTasks = 1000;  // Slurm's own limit (MaxArraySize) unless an administrator raised it

std::string ReadText(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A word as a shell takes it.
std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// What a Slurm command said, and how it ended.
struct Answer {
  Ending ending;
  std::string text;
};

/// Slurm's commands, and the job of this folder.
class SlurmJob {
 public:
  SlurmJob(fs::path runs, SlurmOptions options) : runs_(std::move(runs)), options_(std::move(options)) {
    CheckSlurm();
    std::error_code error;
    fs::create_directories(folder(), error);
    if (error) throw MissingResource("cannot create the folder " + folder().string() + ": " + error.message());
    if (fs::exists(folder() / "job")) std::ifstream(folder() / "job") >> number_;
  }

  fs::path folder() const { return runs_ / "slurm"; }
  const std::string& number() const { return number_; }

  /// Puts the tasks 0 to count - 1 into the queue.
  void Submit(int count, int at_once) {
    std::vector<std::string> words{
        "sbatch", "--parsable", "--job-name=" + options_.job_name,
        fmt::format("--array=0-{}{}", count - 1, at_once > 0 ? fmt::format("%{}", at_once) : std::string()),
        "--output=" + (runs_ / "log" / "slurm-%A_%a.txt").string()};
    words.insert(words.end(), options_.sbatch.begin(), options_.sbatch.end());
    words.push_back((folder() / "array.sh").string());
    const Answer answer = Ask(words);
    number_ = answer.text.substr(0, answer.text.find_first_of(";\n"));  // "12;cluster"
    if (!answer.ending.ok() || number_.empty() || number_.find_first_not_of("0123456789") != std::string::npos)
      throw MissingResource("Slurm does not take the job: " + LastLine(folder() / "said"));
    WriteTextFile(folder() / "job", number_ + "\n");
  }

  /// Whether a task of the job waits or runs.
  bool Active() {
    if (number_.empty()) return false;
    const Answer answer = Ask({"squeue", "--noheader", "--jobs=" + number_, "--format=%T"});
    const bool unknown = answer.text.find("Invalid job id") != std::string::npos;  // ended a while ago
    if (answer.ending.ok() || unknown) {
      silent_ = 0;
      return !unknown && answer.text.find_first_not_of(" \n") != std::string::npos;
    }
    if (++silent_ > 60) throw MissingResource("Slurm does not answer: " + LastLine(folder() / "said"));
    return true;  // its controller may be on its way back
  }

  void Cancel() {
    if (!number_.empty()) Ask({"scancel", number_});
  }

  /// It has ended: no later call need wait for it.
  void Forget() const {
    std::error_code ignored;
    fs::remove(folder() / "job", ignored);
  }

  /// Why a task that left no word ended, as far as Slurm says it.
  std::string WhyTaskEnded(int task) {
    const std::string said = LastLine(runs_ / "log" / fmt::format("slurm-{}_{}.txt", number_, task));
    if (!said.empty()) return said;
    const Answer answer = Ask({"scontrol", "--oneliner", "show", "job", fmt::format("{}_{}", number_, task)});
    const size_t at = answer.text.find("JobState=");
    if (at == std::string::npos) return "its Slurm task did not run it";
    return "its Slurm task ended: " + answer.text.substr(at + 9, answer.text.find(' ', at) - at - 9);
  }

 private:
  Answer Ask(const std::vector<std::string>& words) {
    Subprocess process(words, folder() / "said");
    const std::optional<Ending> ending = process.Wait(60);
    return {ending ? *ending : Ending{-1, 0}, ReadText(folder() / "said")};
  }

  const fs::path runs_;
  const SlurmOptions options_;
  std::string number_;
  int silent_ = 0;  ///< How often in a row Slurm did not answer.
};

/// Those that record a film first: the others of the same film would only wait for it.
std::vector<const WorkItem*> RecordersFirst(const std::vector<const WorkItem*>& items) {
  std::vector<const WorkItem*> ordered = items;
  std::set<std::string> seen;
  std::set<const WorkItem*> first;
  for (const WorkItem* item : items) {
    if (seen.insert(item->frames_hash).second) first.insert(item);
  }
  std::stable_partition(ordered.begin(), ordered.end(), [&](const WorkItem* item) { return first.count(item) > 0; });
  return ordered;
}

/// A task does every `count`-th run of the list, each in a process of its own.
std::string BatchScript(const ExecutorOptions& options, int count) {
  std::error_code error;
  const fs::path program = fs::canonical(options.program, error);
  std::string work = Quoted((error ? options.program : program).string()) + " work " + Quoted(options.runs.string()) +
                     " \"$hash\" --cache-gb " + fmt::format("{}", options.cache.max_gb);
  if (!options.cache.folder.empty()) work += " --cache " + Quoted(options.cache.folder.string());
  return fmt::format(
      "#!/bin/sh\n# One task of a gaitcam study: every {0}th run of the list, from its own number on.\n"
      "export GAITCAM_DATA={1}\ncd {2} || exit 4\n"
      "awk -v task=\"$SLURM_ARRAY_TASK_ID\" '(NR - 1) % {0} == task' slurm/list | while read -r hash; do\n"
      "  {3} >\"log/$hash.log\" 2>&1 </dev/null\n  echo $? >\"log/$hash.code\"\ndone\n",
      count, Quoted(DataFolder().string()), Quoted(options.runs.string()), work);
}

void WriteJob(const SlurmJob& job, const ExecutorOptions& options, const std::vector<const WorkItem*>& todo,
              int count) {
  std::string list;
  for (const WorkItem* item : todo) {
    list += item->hash + "\n";
    std::error_code ignored;
    for (const char* suffix : {".log", ".code"}) fs::remove(options.runs / "log" / (item->hash + suffix), ignored);
  }
  WriteTextFile(job.folder() / "list", list);
  WriteTextFile(job.folder() / "array.sh", BatchScript(options, count));
}

/// Waits until no task of the job waits or runs. @returns false if interrupted; the job is cancelled then.
bool WaitFor(SlurmJob& job, const ExecutorOptions& options, double poll_s, const std::function<void()>& watch) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  while (job.Active()) {
    watch();
    const double poll = Clock::now() - start < std::chrono::seconds(30) ? poll_s : 5 * poll_s;
    const auto next = Clock::now() + std::chrono::duration<double>(poll);
    while (Clock::now() < next) {
      if (options.interrupted()) {
        job.Cancel();
        if (!options.quiet) fmt::print(stderr, "\ngaitcam: cancelled Slurm job {}\n", job.number());
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
  watch();
  return true;
}

/// What became of the runs.
void Collect(SlurmJob& job, const ExecutorOptions& options, const std::vector<const WorkItem*>& todo, int count,
             ExecutorOutcome& outcome) {
  const fs::path log = options.runs / "log";
  for (size_t i = 0; i < todo.size(); ++i) {
    const std::string& hash = todo[i]->hash;
    if (FindJob(options.runs, hash, todo[i]->programs)) {
      ++outcome.done;
      std::error_code ignored;
      for (const char* suffix : {".log", ".code"}) fs::remove(log / (hash + suffix), ignored);
      continue;
    }
    int code = -1;
    std::ifstream(log / (hash + ".code")) >> code;
    const std::string said = LastLine(log / (hash + ".log")), prefix = "gaitcam: ";
    const std::string line = said.starts_with(prefix) ? said.substr(prefix.size()) : said;
    if (code == 4) throw MissingResource(line);
    if (code < 0 || (code > 128 && line.empty())) {
      outcome.failures[hash] =
          code < 0 ? job.WhyTaskEnded(int(i) % count) : fmt::format("the run died of signal {}", code - 128);
    } else {
      outcome.failures[hash] = line.empty() ? fmt::format("the run exited with {}", code) : line;
    }
  }
}

}  // namespace

void CheckSlurm() {
  for (const char* program : {"sbatch", "squeue", "scancel"}) {
    if (IsProgram(program)) continue;
    throw MissingResource(fmt::format(
        "there is no {} on this machine; install Slurm (Debian: slurm-client), or leave out --executor slurm",
        program));
  }
}

ExecutorOutcome ExecuteOnSlurm(const std::vector<WorkItem>& items, const ExecutorOptions& given,
                               const SlurmOptions& slurm) {
  const ExecutorOptions options = internal::Absolute(given);
  internal::MakeRunFolders(options.runs);
  SlurmJob job(options.runs, slurm);
  const FileLock alone = internal::LockRuns(options.runs);
  ExecutorOutcome outcome;
  if (job.Active()) {
    if (!options.quiet) fmt::print(stderr, "gaitcam: waiting for Slurm job {} of an earlier call\n", job.number());
    outcome.interrupted = !WaitFor(job, options, slurm.poll_s, [] {});
    if (outcome.interrupted) return outcome;
  }
  const std::vector<const WorkItem*> todo = RecordersFirst(internal::PrepareItems(items, options, outcome));
  if (todo.empty()) return outcome;
  const int count = int(std::min<size_t>(todo.size(), kMostTasks));
  WriteJob(job, options, todo, count);
  job.Submit(count, options.jobs);
  Progress progress(options.what, int64_t(items.size()), options.quiet);
  outcome.interrupted = !WaitFor(job, options, slurm.poll_s, [&] {
    progress.Update(outcome.reused + std::count_if(todo.begin(), todo.end(), [&](const WorkItem* item) {
                      return fs::exists(options.runs / item->hash / "job.json");
                    }));
  });
  progress.Finish();
  if (outcome.interrupted) return outcome;
  job.Forget();
  Collect(job, options, todo, count, outcome);
  return outcome;
}

}  // namespace gaitcam
