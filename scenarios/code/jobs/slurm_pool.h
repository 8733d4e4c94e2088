/// The pool of processes (pool.h) on a Slurm cluster: its tasks become one job array.
///
/// All machines must see the logs, the programs and the data under the same paths. Everything about the job lies in the
/// pool's folder: the list of commands, the batch script, what the array's tasks say, and the number of the job.

#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scenarios/code/jobs/pool.h"

namespace gaitcam {

struct SlurmOptions {
  std::string job_name = "gaitcam";
  std::vector<std::string> sbatch;  ///< Further options of sbatch, "--partition=long".
  double poll_s = 1;                ///< How often the queue is asked at first; a fifth as often after half a minute.
  bool quiet = false;               ///< Says nothing about jobs on standard error.
};

/// @throws MissingResource if Slurm's commands are not there.
void CheckSlurm();

class SlurmPool {
 public:
  /// @param folder is made if it is not there. @throws MissingResource as CheckSlurm, or if it cannot be made.
  SlurmPool(std::filesystem::path folder, SlurmOptions options);

  /// If an earlier call was killed, its job goes on in the queue: waits for it.
  /// @returns false if interrupted; the job is cancelled then. @throws MissingResource if Slurm does not answer.
  bool WaitForEarlier(const std::function<bool()>& interrupted);

  /// As RunPool; `options.at_once` is the array's limit (0: as Slurm likes). Tasks of one resource start in their
  /// order, but may run beside each other. A task that Slurm ended has failed for the reason that Slurm names.
  /// @returns false if interrupted; the job is cancelled then.
  /// @throws MissingResource as RunPool, or if Slurm does not take the job or does not answer.
  bool Run(const std::vector<PoolTask>& tasks, const PoolOptions& options);

 private:
  struct Answer {
    Ending ending;
    std::string text;
  };
  Answer Ask(const std::vector<std::string>& words) const;
  void Submit(int count, int at_once);
  bool Active();
  void Cancel() const;
  bool Wait(const std::function<bool()>& interrupted, const std::function<void()>& watch);
  std::string WhyTaskEnded(int array_task) const;

  const std::filesystem::path folder_;
  const SlurmOptions options_;
  std::string number_;  ///< Of the job; empty: there is none.
  int silent_ = 0;      ///< How often in a row Slurm did not answer.
};

}  // namespace gaitcam
