#include "scenarios/code/systems/family_watch.h"

#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>
#include <vector>

#include "scenarios/code/systems/process_list.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr double kBytesPerMb = 1e6;
constexpr int kMaxDepth = 64;

/// So that a thousand others that want the processors do not keep the calling thread from them. Needs a right that root
/// has; without it nothing changes.
void RunBeforeOthers() {
  sched_param least = {};
  least.sched_priority = sched_get_priority_min(SCHED_FIFO);
  sched_setscheduler(0, SCHED_FIFO, &least);
}

/// "it wrote more than 10000 files"; empty while the folder keeps within its limits. What comes and goes meanwhile may
/// be missed; files with holes count for what they take of the disk. Each level takes a descriptor of ours. What may
/// not be read cannot be counted, and is an offence.
std::string OffenceIn(const FamilyLimits& limits) {
  if (limits.folder.empty()) return "";
  uint64_t in_use = 0;
  size_t files = 0;
  std::error_code ended;
  fs::recursive_directory_iterator entry(limits.folder, ended);
  for (; !ended && entry != fs::recursive_directory_iterator(); entry.increment(ended)) {
    if (++files > limits.folder_files) return fmt::format("it wrote more than {} files", limits.folder_files);
    if (entry.depth() >= kMaxDepth) return fmt::format("it wrote into folders more than {} deep", kMaxDepth);
    struct stat status = {};
    constexpr uint64_t kBlock_bytes = 512;  // whatever the file system's own are
    if (lstat(entry->path().c_str(), &status) == 0) in_use += uint64_t(status.st_blocks) * kBlock_bytes;
  }
  if (ended == std::errc::permission_denied) return "it made a folder that nobody may read";
  if (in_use <= limits.folder_bytes) return "";
  return fmt::format("it wrote more than {:g} MB of files", double(limits.folder_bytes) / kBytesPerMb);
}

}  // namespace

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

std::string FamilyWatch::KilledFor() {
  const std::lock_guard lock(mutex_);
  return offence_;
}

std::string FamilyWatch::LeftBehind() const { return OffenceIn(limits_); }

void FamilyWatch::Watch() {
  using std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kBetweenGlances(20), kBetweenLooks(200);
  RunBeforeOthers();
  size_t tasks_then = MachineTasks();
  steady_clock::time_point looked = steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kBetweenGlances, [this] { return ends_; })) {
    const size_t tasks = MachineTasks();
    tasks_then = std::min(tasks_then, tasks);
    const bool many = tasks - tasks_then > limits_.processes;
    if (!many && steady_clock::now() - looked < kBetweenLooks) continue;
    if (many) SignalGroups(SIGSTOP);  // what doubles would be twice as many when they are counted
    const std::string offence = OffenceNow();
    if (!offence.empty()) {
      if (offence_.empty()) offence_ = offence;
      KillAll();
    } else if (many) {
      SignalGroups(SIGCONT);
      tasks_then = tasks;
    }
    looked = steady_clock::now();
  }
}

/// The groups of the root, of its children and of theirs, a sandbox's among them; all of a group get a signal at once,
/// and none can fork meanwhile.
void FamilyWatch::SignalGroups(int signal) const {
  std::set<pid_t> groups = {root_};
  std::vector<pid_t> generation = {root_};
  for (int depth = 0; depth < 2; ++depth) {
    std::vector<pid_t> next;
    for (const pid_t parent : generation) {
      for (const pid_t child : ChildrenOf(parent)) next.push_back(child);
    }
    for (const pid_t pid : next) groups.insert(getpgid(pid));
    generation = std::move(next);
  }
  for (const pid_t group : groups) {
    if (group > 1 && group != getpgrp()) kill(-group, signal);
  }
}

std::string FamilyWatch::OffenceNow() const {
  const std::vector<pid_t> family = Family(root_, mark_);
  if (family.size() > limits_.processes) return fmt::format("it started more than {} processes", limits_.processes);
  uint64_t in_use = 0;
  for (const pid_t pid : family) in_use += PrivateMemory_bytes(pid);
  if (in_use > limits_.memory_bytes)
    return fmt::format("it took more than {:g} MB of memory", double(limits_.memory_bytes) / kBytesPerMb);
  return OffenceIn(limits_);
}

/// Groups at once, and with a sandbox's first process the kernel ends all in it. Others are stopped before they are
/// killed: who saw another die could start a new one, and whoever has lost all its parents is found by its mark alone.
void FamilyWatch::KillAll() const {
  constexpr int kMaxRounds = 20;
  std::set<pid_t> all = {root_};
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<pid_t> family = Family(root_, mark_);
    if (round == 0) SignalGroups(SIGKILL);
    for (const pid_t pid : family) kill(pid, SIGSTOP);
    const size_t before = all.size();
    all.insert(family.begin(), family.end());
    if (all.size() == before) break;
  }
  for (const pid_t pid : all) kill(pid, SIGKILL);
}

}  // namespace gaitcam
