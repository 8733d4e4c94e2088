/// A pool of processes: many commands, at most so many at once, each in a process of its own with a log of its own.
/// Studies, suites and matrices of recordings do their work through it, here or on a cluster (slurm_pool.h).

#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {

/// One command.
struct PoolTask {
  std::string name;                  ///< Unique within the pool.
  std::vector<std::string> command;  ///< Program and arguments; paths are absolute.
  std::filesystem::path log;         ///< Receives standard output and standard error.
  std::string resource = {};         ///< Produced by the first task that names it, used by the others; empty: none.
};

/// How a task ended.
struct TaskEnd {
  enum class Kind {
    kDone,    ///< Exit code 0.
    kFailed,  ///< Any other exit code but 4, or a signal.
    kKilled,  ///< It was running when the pool was left: an interrupt, or an exception.
  };
  Kind kind = Kind::kDone;
  std::string reason = {};  ///< Of a failure: the last line of the log, else how the process ended.
};

struct PoolOptions {
  int at_once = 0;  ///< Processes at once; 0: one per core.
  std::function<bool()> interrupted = [] { return false; };
  std::function<void(const PoolTask&)> on_start = [](const PoolTask&) {};
  std::function<void(const PoolTask&, const TaskEnd&)> on_end = [](const PoolTask&, const TaskEnd&) {};
  /// Some twenty times a second, with the tasks that run.
  std::function<void(const std::vector<const PoolTask*>& running)> on_poll = [](const auto&) {};
};

/// Runs tasks in their order, except that tasks which share a resource wait until one of them has succeeded.
/// Where several run at once, the environment tells their renderer and OpenCV which share of the cores is theirs
/// (LP_NUM_THREADS, OPENCV_FOR_THREADS_NUM), unless it says so already.
/// @returns false if interrupted; processes that run are killed then.
/// @throws MissingResource with the last line of the log when a process exits with 4: the machine lacks something that
/// the others need as well.
bool RunPool(const std::vector<PoolTask>& tasks, const PoolOptions& options);

/// The outcome of a task whose process has ended: exit codes as in algorithms/core/errors.h, reasons from the log.
/// @throws MissingResource as RunPool does.
TaskEnd TaskEndOf(const Ending& ending, const std::filesystem::path& log);

}  // namespace gaitcam
