#include "scenarios/code/jobs/pool.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <list>
#include <map>
#include <set>
#include <thread>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Tasks that wait, and the state of the resources that they share.
class TaskQueue {
 public:
  explicit TaskQueue(const std::vector<PoolTask>& tasks) {
    for (const PoolTask& task : tasks) waiting_.push_back(&task);
  }

  /// The first task whose resource is not being made just now; null if there is none.
  const PoolTask* Next() {
    for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
      const PoolTask* task = *it;
      const bool needs = !task->resource.empty() && made_.count(task->resource) == 0;
      if (needs && !being_made_.insert(task->resource).second) continue;
      waiting_.erase(it);
      return task;
    }
    return nullptr;
  }
  void End(const PoolTask& task, bool ok) {
    being_made_.erase(task.resource);
    if (ok) made_.insert(task.resource);
  }
  bool empty() const { return waiting_.empty(); }

 private:
  std::deque<const PoolTask*> waiting_;
  std::set<std::string> made_, being_made_;
};

/// A share of the cores for each of `at_once` processes. Mesa's software renderer and OpenCV would each start as many
/// threads as there are cores, which wait for each other when others use the cores as well; pixels and poses do not
/// depend on their number.
std::map<std::string, std::string> ThreadsOfEach(size_t cores, size_t at_once) {
  const size_t share = std::max<size_t>(1, cores / at_once);
  if (share == cores) return {};
  return {{"LP_NUM_THREADS", std::to_string(share == 1 ? 0 : share)},  // 0: the caller's thread does it all
          {"OPENCV_FOR_THREADS_NUM", std::to_string(share)}};
}

/// The processes that run. They are killed, and reported so, if it is left before they end.
class RunningTasks {
 public:
  RunningTasks(const PoolOptions& options, std::map<std::string, std::string> variables)
      : options_(options), variables_(std::move(variables)) {}
  ~RunningTasks() {
    const std::vector<const PoolTask*> tasks = Tasks();
    running_.clear();  // kills
    for (const PoolTask* task : tasks) options_.on_end(*task, {TaskEnd::Kind::kKilled, "killed"});
  }
  RunningTasks(const RunningTasks&) = delete;
  RunningTasks& operator=(const RunningTasks&) = delete;

  size_t size() const { return running_.size(); }
  std::vector<const PoolTask*> Tasks() const {
    std::vector<const PoolTask*> tasks;
    for (const Member& member : running_) tasks.push_back(member.task);
    return tasks;
  }
  void Start(const PoolTask& task) {
    options_.on_start(task);
    running_.push_back({&task, Subprocess(task.command, SubprocessStreams{.log = task.log, .variables = variables_})});
  }
  /// Takes out those that have ended.
  void Reap(TaskQueue& queue) {
    for (auto it = running_.begin(); it != running_.end();) {
      const std::optional<Ending> ending = it->process.Poll();
      if (!ending) {
        ++it;
        continue;
      }
      const PoolTask& task = *it->task;
      const TaskEnd end = TaskEndOf(*ending, task.log);
      it = running_.erase(it);
      queue.End(task, ending->ok());
      options_.on_end(task, end);
    }
  }

 private:
  struct Member {
    const PoolTask* task;
    Subprocess process;
  };
  const PoolOptions& options_;
  const std::map<std::string, std::string> variables_;
  std::list<Member> running_;
};

}  // namespace

TaskEnd TaskEndOf(const Ending& ending, const std::filesystem::path& log) {
  if (ending.ok()) return {};
  std::string line = LastLine(log);
  if (const std::string prefix = "gaitcam: "; line.starts_with(prefix)) line = line.substr(prefix.size());
  if (ending.code == 4) throw MissingResource(line);
  const bool crashed = ending.signal != 0 || line.empty();
  return {TaskEnd::Kind::kFailed, crashed ? "the process " + ending.ToText() : line};
}

bool RunPool(const std::vector<PoolTask>& tasks, const PoolOptions& options) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kWait = std::chrono::milliseconds(5), kReport = std::chrono::milliseconds(50);
  const size_t cores = std::max(1U, std::thread::hardware_concurrency());
  const size_t at_once = options.at_once > 0 ? size_t(options.at_once) : cores;
  TaskQueue queue(tasks);
  RunningTasks running(options, ThreadsOfEach(cores, std::clamp<size_t>(tasks.size(), 1, at_once)));
  Clock::time_point reported = Clock::now();
  while (!queue.empty() || running.size() > 0) {
    if (options.interrupted()) return false;
    while (running.size() < at_once) {
      const PoolTask* task = queue.Next();
      if (task == nullptr) break;
      running.Start(*task);
    }
    const size_t before = running.size();
    running.Reap(queue);
    if (running.size() < before) continue;
    if (Clock::now() - reported >= kReport) {
      options.on_poll(running.Tasks());
      reported = Clock::now();
    }
    std::this_thread::sleep_for(kWait);
  }
  return true;
}

}  // namespace gaitcam
