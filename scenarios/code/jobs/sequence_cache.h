/// A cache of recorded walks: runs that differ only in the SLAM system share one rendering.
///
/// The key of a sequence is a hash of what determines its frames: the scenario (FramesHashOf), the code that makes
/// frames, and the renderer. It is a dataset folder with its truth beside it, as `record` writes it, but without truth
/// images; reading it gives a SLAM system the same bits as the simulation would. Any number of processes may share one
/// cache: one of them records a sequence while the others that need it wait, and none is removed while in use.

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/trajectory.h"
#include "algorithms/io/dataset_layout.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/file_lock.h"
#include "scenarios/code/runs/recorded_walk.h"

namespace gaitcam {

struct SequenceCacheOptions {
  std::filesystem::path folder;  ///< Empty: $XDG_CACHE_HOME/gaitcam/sequences, else ~/.cache/gaitcam/sequences.
  double max_gb = 20;            ///< Above this size the least recently used sequences are removed.
};

/// One recorded walk, locked against removal while the object lives.
struct CachedSequence {
  DatasetFolders folders;
  std::string status;  ///< How the walk ended: "finished", "fell".
  double end_time_s = 0, distance_m = 0;
  int64_t frames = 0;
  RendererInfo renderer;
  bool was_there = false;  ///< True: it was in the cache; false: recorded by this call.
  FileLock lock;

  /// groundtruth.txt: X_WC of the left camera, one pose per frame.
  Trajectory Truth() const;
  /// What is true of each frame.
  std::vector<FrameTruth> ReadFrames() const;
};

class SequenceCache {
 public:
  /// @throws MissingResource if the folder cannot be made.
  explicit SequenceCache(const SequenceCacheOptions& options);

  /// The frames of a scenario: from the cache, else recorded by this call.
  /// @returns nothing if interrupted; then no files are left.
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

/// The folder of the cache unless --cache names another. @throws MissingResource if neither $XDG_CACHE_HOME nor $HOME
/// is set.
std::filesystem::path DefaultCacheFolder();

}  // namespace gaitcam
