/// Recorded walks that are used again: runs that differ in the SLAM system alone share one rendering.
///
/// A sequence is known by what decides its frames: the scenario (FramesHashOf), the code that makes frames, and the
/// renderer. It is a dataset folder with its truth beside it, as `record` writes it, but without truth images; reading
/// it gives a SLAM system the same bits as the simulation would. Any number of processes may share one cache: a
/// sequence is recorded by one of them while the others that want it wait, and none is removed while in use.

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/trajectory.h"
#include "algorithms/io/dataset_layout.h"
#include "scenarios/runs/file_lock.h"
#include "scenarios/runs/recorded_walk.h"
#include "scenarios/scenario.h"

namespace gaitcam {

struct SequenceCacheOptions {
  std::filesystem::path folder;  ///< Empty: $XDG_CACHE_HOME/gaitcam/sequences, else ~/.cache/gaitcam/sequences.
  double max_gb = 20;            ///< When it is larger, what was used longest ago goes first.
};

/// One recorded walk, safe from removal while the object lives.
struct CachedSequence {
  DatasetFolders folders;
  std::string status;  ///< How the walk ended: "finished", "fell".
  double end_time_s = 0, distance_m = 0;
  int64_t frames = 0;
  std::string renderer;
  bool software_renderer = false;
  bool was_there = false;  ///< It was not recorded just now.
  FileLock lock;

  /// groundtruth.txt: X_WC of the left camera, one pose per frame.
  Trajectory Truth() const;
  /// What is true of each frame.
  std::vector<RecordedTruth> ReadFrames() const;
};

class SequenceCache {
 public:
  /// @throws MissingResource if the folder cannot be made.
  explicit SequenceCache(const SequenceCacheOptions& options);

  /// The frames of a scenario: those that are there, else recorded now.
  /// @returns nothing if `interrupted` said so; then nothing is left behind.
  /// @throws BadInput, MissingResource as recording does.
  std::optional<CachedSequence> Get(const ResolvedScenario& resolved, bool quiet,
                                    const std::function<bool()>& interrupted) const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::optional<CachedSequence> Open(const std::filesystem::path& entry) const;
  bool Record(const ResolvedScenario& resolved, const std::filesystem::path& entry, bool quiet,
              const std::function<bool()>& interrupted) const;
  void Prune() const;

  std::filesystem::path folder_;
  double max_gb_;
};

/// Where sequences lie unless said otherwise. @throws MissingResource if neither $XDG_CACHE_HOME nor $HOME is set.
std::filesystem::path DefaultCacheFolder();

}  // namespace gaitcam
