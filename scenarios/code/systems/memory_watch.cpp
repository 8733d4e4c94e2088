#include "scenarios/code/systems/memory_watch.h"

#include <signal.h>

#include <chrono>
#include <utility>

#include "scenarios/code/systems/process_list.h"

namespace gaitcam {

MemoryWatch::MemoryWatch(pid_t root, std::string mark, uint64_t max_bytes)
    : root_(root), mark_(std::move(mark)), max_bytes_(max_bytes), thread_([this] { Watch(); }) {}

MemoryWatch::~MemoryWatch() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void MemoryWatch::Watch() {
  constexpr std::chrono::milliseconds kBetween(200);
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kBetween, [this] { return ends_; })) {
    uint64_t in_use = 0;
    const std::vector<pid_t> family = Family(root_, mark_);
    for (const pid_t pid : family) in_use += PrivateMemory_bytes(pid);
    if (in_use <= max_bytes_) continue;
    exceeded_ = true;
    for (const pid_t pid : family) kill(pid, SIGKILL);
  }
}

}  // namespace gaitcam
