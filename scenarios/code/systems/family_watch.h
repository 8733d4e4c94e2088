/// Limits to somebody else's program, of all its processes together.

#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

namespace gaitcam {

struct FamilyLimits {
  uint64_t memory_bytes = UINT64_MAX;
  size_t processes = SIZE_MAX;
  std::filesystem::path folder = {};  ///< Where they may write; empty: it is not looked at.
  uint64_t folder_bytes = UINT64_MAX;
  size_t folder_files = SIZE_MAX;
};

/// Looks five times a second at a process and its family (process_list.h), and kills all of them once they have more
/// memory in use, are more, or have written more than they may; at once where the machine has so many more processes,
/// which are stopped while they are counted. The kernel's own limits of memory are of one process, and of what it
/// reserves, not uses: sanitizers and drivers of graphics cards reserve terabytes. Those of processes are of a user,
/// and not of root. Memory that is shared, of other programs' or with files of a folder in memory behind it, does not
/// count; what a fork left in common counts for each that has it.
class FamilyWatch {
 public:
  /// @param mark what the environment of the family's processes holds
  FamilyWatch(pid_t root, std::string mark, const FamilyLimits& limits);
  /// Ends the watch, within the time of one look.
  ~FamilyWatch();
  FamilyWatch(const FamilyWatch&) = delete;
  FamilyWatch& operator=(const FamilyWatch&) = delete;

  /// "it took more than 500 MB of memory"; empty while they keep within their limits.
  std::string KilledFor();
  /// "it wrote more than 10000 files": what may have been written since the last look; empty if that is within limits.
  std::string LeftBehind() const;

 private:
  void Watch();
  std::string OffenceNow() const;
  void SignalGroups(int signal) const;
  void KillAll() const;

  pid_t root_;
  std::string mark_;
  FamilyLimits limits_;
  std::string offence_;
  bool ends_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace gaitcam
