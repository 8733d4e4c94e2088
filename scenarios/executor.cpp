#include "scenarios/executor.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <deque>
#include <fstream>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"
#include "scenarios/interrupt.h"
#include "scenarios/output_folder.h"
#include "scenarios/progress.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

fs::path PlanOf(const fs::path& runs, const std::string& hash) { return runs / "plan" / (hash + ".yaml"); }
fs::path LogOf(const fs::path& runs, const std::string& hash) { return runs / "log" / (hash + ".log"); }

std::string LastLine(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

/// Starts `gaitcam work` on one item, its words going to its log. The child dies with its parent.
pid_t StartWorker(const WorkItem& item, const ExecutorOptions& options) {
  const std::string runs = options.runs.string(), cache = options.cache.folder.string();
  const std::string log = LogOf(options.runs, item.hash).string(), max_gb = fmt::format("{}", options.cache.max_gb);
  std::vector<const char*> words{"gaitcam", "work", runs.c_str(), item.hash.c_str(), "--cache-gb", max_gb.c_str()};
  if (!cache.empty()) words.insert(words.end(), {"--cache", cache.c_str()});
  words.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw MissingResource("cannot start another process");
  if (child > 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  setpgid(0, 0);  // Ctrl-C is the parent's to handle
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out >= 0) {
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
  }
  execv("/proc/self/exe", const_cast<char* const*>(words.data()));
  _exit(127);
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

/// The processes in flight.
class Crew {
 public:
  Crew(const ExecutorOptions& options, ExecutorOutcome& outcome) : options_(options), outcome_(outcome) {}
  ~Crew() {
    for (const auto& [child, item] : running_) kill(child, SIGKILL);
    for (const auto& [child, item] : running_) waitpid(child, nullptr, 0);
  }

  size_t size() const { return running_.size(); }
  void Start(const WorkItem& item) { running_[StartWorker(item, options_)] = &item; }

  /// Waits a moment for one to end. @returns the item that has, or null.
  const WorkItem* Reap(bool& ok) {
    for (auto it = running_.begin(); it != running_.end(); ++it) {
      int status = 0;
      if (waitpid(it->first, &status, WNOHANG) != it->first) continue;
      const WorkItem* item = it->second;
      running_.erase(it);
      ok = WIFEXITED(status) && WEXITSTATUS(status) == 0;
      Judge(*item, status);
      return item;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return nullptr;
  }

 private:
  void Judge(const WorkItem& item, int status) {
    const fs::path log = LogOf(options_.runs, item.hash);
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == 0) {
      std::error_code ignored;
      fs::remove(log, ignored);
      ++outcome_.done;
      return;
    }
    const std::string said = LastLine(log), prefix = "gaitcam: ";
    const std::string line = said.starts_with(prefix) ? said.substr(prefix.size()) : said;
    if (code == 4) throw MissingResource(line);
    outcome_.failures[item.hash] =
        WIFSIGNALED(status) ? fmt::format("the process died of signal {}", WTERMSIG(status)) : line;
  }

  const ExecutorOptions& options_;
  ExecutorOutcome& outcome_;
  std::map<pid_t, const WorkItem*> running_;
};

/// What remains to be done, its scenarios written down.
std::vector<const WorkItem*> Prepare(const std::vector<WorkItem>& items, const ExecutorOptions& options,
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

void MakeFolders(const fs::path& runs) {
  for (const char* name : {"plan", "log"}) {
    std::error_code error;
    fs::create_directories(runs / name, error);
    if (error) throw MissingResource("cannot create the folder " + (runs / name).string() + ": " + error.message());
  }
}

}  // namespace

WorkItem WorkItemOf(const ResolvedScenario& resolved, const std::string& label) {
  return {HashOf(resolved), FramesHashOf(resolved), resolved.ToYaml(), ProgramsFingerprint(resolved.scenario), label};
}

ExecutorOutcome ExecuteLocally(const std::vector<WorkItem>& items, const ExecutorOptions& given) {
  ExecutorOptions options = given;
  options.runs = fs::absolute(given.runs);
  if (!given.cache.folder.empty()) options.cache.folder = fs::absolute(given.cache.folder);
  MakeFolders(options.runs);
  const FileLock alone = FileLock(options.runs / "lock", FileLock::Kind::kExclusive);
  ExecutorOutcome outcome;
  Schedule schedule(Prepare(items, options, outcome));
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
