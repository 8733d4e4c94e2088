#include "scenarios/code/systems/family_watch.h"

#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <utility>

#include "scenarios/code/systems/process_list.h"

namespace gaitcam {

FamilyWatch::FamilyWatch(pid_t root, std::string mark, const FamilyLimits& limits)
    : root_(root), mark_(std::move(mark)), limits_(limits), thread_([this] { Watch(); }) {}

FamilyWatch::~FamilyWatch() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

std::string FamilyWatch::offence() {
  const std::lock_guard lock(mutex_);
  return offence_;
}

void FamilyWatch::Watch() {
  constexpr std::chrono::milliseconds kBetween(200);
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kBetween, [this] { return ends_; })) {
    const std::string offence = OffenceNow();
    if (offence.empty()) continue;
    if (offence_.empty()) offence_ = offence;
    KillAll();
  }
}

std::string FamilyWatch::OffenceNow() const {
  const std::vector<pid_t> family = Family(root_, mark_);
  if (family.size() > limits_.processes) return fmt::format("it started more than {} processes", limits_.processes);
  uint64_t in_use = 0;
  for (const pid_t pid : family) in_use += PrivateMemory_bytes(pid);
  constexpr double kBytesPerMb = 1e6;
  if (in_use <= limits_.memory_bytes) return "";
  return fmt::format("it took more than {:g} MB of memory", double(limits_.memory_bytes) / kBytesPerMb);
}

/// They are stopped before they are killed, the root last: who saw another die could start a new one, and whoever has
/// lost all its parents is found by its mark alone.
void FamilyWatch::KillAll() const {
  constexpr int kMaxRounds = 20;
  size_t before = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<pid_t> family = Family(root_, mark_);
    for (const pid_t pid : family) kill(pid, SIGSTOP);
    if (family.size() == before) break;
    before = family.size();
  }
  for (const pid_t pid : Family(root_, mark_)) {
    if (pid != root_) kill(pid, SIGKILL);
  }
  kill(root_, SIGKILL);
}

}  // namespace gaitcam
