/// Many runs on a Slurm cluster: the same runs as ExecuteLocally, as the tasks of one job array.
///
/// All machines must see the folder of the runs, the cache and the program under the same paths. Everything about the
/// job lies in runs/slurm: the list of runs, the batch script, and the number of the job.

#pragma once

#include <string>
#include <vector>

#include "scenarios/jobs/executor.h"

namespace gaitcam {

struct SlurmOptions {
  std::string job_name = "gaitcam";
  std::vector<std::string> sbatch;  ///< Further options of sbatch, "--partition=long".
  double poll_s = 1;                ///< How often the queue is asked at first; five times as long after half a minute.
};

/// @throws MissingResource if Slurm's commands are not there.
void CheckSlurm();

/// Submits what is not done yet, waits, and collects. `options.jobs` is the most tasks at once; 0: as Slurm likes. An
/// interrupt cancels the job. If an earlier call was killed, its job goes on in the queue: that one is waited for
/// first.
/// @throws MissingResource if there is no Slurm, or it does not take the job, or a run says that its machine lacks
/// something; BadInput if another executor works in the same folder.
ExecutorOutcome ExecuteOnSlurm(const std::vector<WorkItem>& items, const ExecutorOptions& options,
                               const SlurmOptions& slurm);

}  // namespace gaitcam
