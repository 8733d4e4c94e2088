/// Many runs, each in a process of its own: what crashes is one run, and what is killed is at most the runs in flight.

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "scenarios/jobs/job.h"

namespace gaitcam {

/// One run to be done.
struct WorkItem {
  std::string hash;           ///< HashOf the scenario: names the run's folder.
  std::string frames_hash;    ///< Items that share it share one rendering.
  std::string scenario_yaml;  ///< Resolved.
  std::string programs;       ///< ProgramsFingerprint: a finished run of other programs is run again.
  std::string label;          ///< For people: "exposure_ms=20, sift_vo, seed 3".
};

/// @param program the gaitcam that is to do it.
WorkItem WorkItemOf(const ResolvedScenario& resolved, const std::string& label,
                    const std::filesystem::path& program = "/proc/self/exe");

struct ExecutorOptions {
  std::filesystem::path runs;  ///< Folder of the runs' folders.
  SequenceCacheOptions cache;
  std::filesystem::path program = "/proc/self/exe";  ///< The gaitcam that does the runs.
  int jobs = 0;                                      ///< Processes at once; 0: one per core.
  std::string what = "runs";                         ///< Label of the progress line.
  bool quiet = false;
  std::function<bool()> interrupted = [] { return false; };
};

struct ExecutorOutcome {
  int reused = 0, done = 0;
  bool interrupted = false;
  std::map<std::string, std::string> failures;  ///< Hash to the last line that a process said that did not end well.
};

/// Does what is not done yet. Items of the same frames wait until one of them has them recorded. Scenarios lie in
/// runs/plan/HASH.yaml, what a failed process said in runs/log/HASH.log.
/// @throws BadInput if another executor works in the same folder; MissingResource if the machine lacks something that
/// the runs need, at the first that says so.
ExecutorOutcome ExecuteLocally(const std::vector<WorkItem>& items, const ExecutorOptions& options);

/// The one run that a process of an executor does: reads runs/plan/HASH.yaml. @returns the exit code.
int WorkOn(const std::filesystem::path& runs, const std::string& hash, const SequenceCacheOptions& cache);

namespace internal {

/// Parts of every executor. The options with all paths absolute.
ExecutorOptions Absolute(ExecutorOptions options);
/// runs/plan and runs/log. @throws MissingResource.
void MakeRunFolders(const std::filesystem::path& runs);
/// Held while an executor works in a folder. @throws BadInput if another one keeps it for longer than a killed one
/// would.
FileLock LockRuns(const std::filesystem::path& runs);
/// What remains to be done, its scenarios written down; the rest is counted as reused.
std::vector<const WorkItem*> PrepareItems(const std::vector<WorkItem>& items, const ExecutorOptions& options,
                                          ExecutorOutcome& outcome);

}  // namespace internal
}  // namespace gaitcam
