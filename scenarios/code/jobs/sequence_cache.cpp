#include "scenarios/code/jobs/sequence_cache.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/trajectory_file.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/cache_entry.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/recorder.h"
#include "scenarios/code/runs/renderer_record.h"
#include "sim/camera/egl_context.h"

namespace gaitcam {
namespace fs = std::filesystem;

Trajectory CachedSequence::Truth() const {
  return ReadTrajectory(folders.truth / "groundtruth.txt", TrajectoryFormat::kTum).trajectory;
}

std::vector<FrameTruth> CachedSequence::ReadFrames() const { return ReadRecordedTruth(folders); }

fs::path DefaultCacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "gaitcam/sequences";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache/gaitcam/sequences";
  throw MissingResource("neither XDG_CACHE_HOME nor HOME is set; say --cache FOLDER");
}

SequenceCache::SequenceCache(const SequenceCacheOptions& options)
    : folder_(fs::absolute(options.folder.empty() ? DefaultCacheFolder() : options.folder)), max_gb_(options.max_gb) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw MissingResource("cannot create the folder " + folder_.string() + ": " + error.message());
}

std::optional<CachedSequence> SequenceCache::Get(const ResolvedScenario& resolved, bool quiet,
                                                 const std::function<bool()>& interrupted) const {
  const std::string renderer = RendererKey(resolved.scenario.camera.renderer);
  const std::string key = Sha256(FramesHashOf(resolved) + FramesFingerprint() + renderer).substr(0, 32);
  const fs::path entry = folder_ / key;
  for (bool recorded = false;; recorded = true) {
    if (std::optional<CachedSequence> sequence = Open(entry)) {
      sequence->was_there = !recorded;
      return sequence;
    }
    Prune();
    const FileLock alone(CacheEntryLock(entry), FileLock::Kind::kExclusive);
    if (fs::exists(entry / kCacheEntryAbout)) continue;  // another process has recorded it meanwhile
    if (!Record(resolved, entry, quiet, interrupted)) return std::nullopt;
  }
}

std::optional<CachedSequence> SequenceCache::Open(const fs::path& entry) const {
  FileLock lock(CacheEntryLock(entry), FileLock::Kind::kShared);
  const std::optional<std::string> text = FindFileContent(entry / kCacheEntryAbout);
  if (!text) return std::nullopt;
  const nlohmann::json about = nlohmann::json::parse(*text, nullptr, false);
  if (about.is_discarded()) throw BadInput((entry / kCacheEntryAbout).string() + ": damaged; remove this folder");
  fs::last_write_time(entry / kCacheEntryAbout, fs::file_time_type::clock::now());  // for the order of removal
  return CachedSequence{DatasetFolders::In(entry, "sequence"),
                        about.at("status"),
                        about.at("end_time_s"),
                        about.at("distance_m"),
                        about.at("frames"),
                        ReadRenderer(about),
                        true,
                        std::move(lock)};
}

bool SequenceCache::Record(const ResolvedScenario& resolved, const fs::path& entry, bool quiet,
                           const std::function<bool()>& interrupted) const {
  RemoveUnfinished(entry);  // the entry is locked: its writer is dead
  OutputFolder folder(entry, "");
  RecordOptions options;
  options.truth_images = false;
  options.format.png_compression = 0;  // twice the size, less than half the time to read, for each system anew
  options.quiet = quiet;
  options.interrupted = interrupted;
  ResolvedScenario right = resolved;  // what systems are told wrong comes after the cache: they share one recording
  right.scenario.calibration_error = {};
  const RecordOutcome outcome = RecordScenario(right, DatasetFolders::In(folder.path(), "sequence"), options);
  if (outcome.status == "interrupted") return false;
  nlohmann::ordered_json about{{"scenario", resolved.scenario.name},
                               {"status", outcome.status},
                               {"end_time_s", outcome.end_time_s},
                               {"distance_m", outcome.distance_m},
                               {"frames", outcome.frames}};
  WriteRenderer(outcome.renderer, about);
  NoteCacheEntrySize(folder);
  folder.WriteText(kCacheEntryAbout, about.dump(2) + "\n");
  folder.Commit();
  return true;
}

/// Removes the least recently used entries, except those in use, until the rest fits.
void SequenceCache::Prune() const {
  struct Entry {
    fs::file_time_type used;
    uintmax_t bytes;
    fs::path folder;
  };
  std::vector<Entry> entries;
  double total = 0;
  for (const auto& item : fs::directory_iterator(folder_)) {
    std::error_code gone;
    const auto used = fs::last_write_time(item.path() / kCacheEntryAbout, gone);
    if (gone) continue;
    entries.push_back({used, CacheEntrySize(item.path()), item.path()});
    total += double(entries.back().bytes);
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (total <= max_gb_ * 1e9) return;
    FileLock::TryExclusive(CacheEntryLock(entry.folder), [&] {
      std::error_code ignored;
      fs::remove_all(entry.folder, ignored);
      total -= double(entry.bytes);
    });
  }
}

}  // namespace gaitcam
