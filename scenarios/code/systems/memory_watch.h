/// A limit to the memory of somebody else's program, of all its processes together.

#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace gaitcam {

/// Looks five times a second how much memory a process and its family (process_list.h) have in use, and kills all of
/// them once it is more than they may. The kernel's own limits are of one process, and of what it reserves, not uses:
/// sanitizers and drivers of graphics cards reserve terabytes. Memory that is shared, of other programs' or with files
/// of a folder in memory behind it, does not count; what a fork left in common counts for each that has it.
class MemoryWatch {
 public:
  /// @param mark what the environment of the family's processes holds. @param max_bytes of all of them together.
  MemoryWatch(pid_t root, std::string mark, uint64_t max_bytes);
  /// Ends the watch, within the time of one look.
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

  bool exceeded() const { return exceeded_; }

 private:
  void Watch();

  pid_t root_;
  std::string mark_;
  uint64_t max_bytes_;
  std::atomic<bool> exceeded_ = false;
  bool ends_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace gaitcam
