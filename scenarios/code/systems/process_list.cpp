#include "scenarios/code/systems/process_list.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// All of a file of /proc, whose process may end while it is read: what was read until then.
std::string TextOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::array<char, 4096> part;
  // Not by iterators over its buffer: they throw where reading fails, and that is what ends a process.
  while (file.read(part.data(), part.size()), file.gcount() > 0) text.append(part.data(), size_t(file.gcount()));
  return text;
}

/// Of each process, its parent.
std::map<pid_t, pid_t> Parents() {
  std::map<pid_t, pid_t> parents;
  std::error_code ignored;
  for (fs::directory_iterator entry("/proc", ignored), end; entry != end; entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    pid_t pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ec != std::errc()) continue;
    const std::string text = TextOf(entry->path() / "stat");  // "pid (name) state parent ..."
    const size_t name_end = text.rfind(')');
    int parent = 0;
    if (name_end != std::string::npos && std::sscanf(text.c_str() + name_end, ") %*c %d", &parent) == 1)
      parents[pid] = parent;
  }
  return parents;
}

void AddDescendants(const std::map<pid_t, pid_t>& parents, std::set<pid_t>& family) {
  for (size_t before = 0; before != family.size();) {
    before = family.size();
    for (const auto& [pid, parent] : parents) {
      if (family.count(parent) != 0) family.insert(pid);
    }
  }
}

bool IsMarked(pid_t pid, const std::string& mark) {
  return TextOf("/proc/" + std::to_string(pid) + "/environ").find(mark) != std::string::npos;
}

}  // namespace

std::vector<pid_t> Marked(const std::string& mark) {
  std::vector<pid_t> found;
  for (const auto& [pid, parent] : Parents()) {
    if (IsMarked(pid, mark)) found.push_back(pid);
  }
  return found;
}

std::vector<pid_t> Children() {
  std::vector<pid_t> found;
  for (const auto& [pid, parent] : Parents()) {
    if (parent == getpid()) found.push_back(pid);
  }
  return found;
}

std::vector<pid_t> ChildrenOf(pid_t parent) {
  const std::string number = std::to_string(parent);
  std::ifstream file("/proc/" + number + "/task/" + number + "/children");
  std::vector<pid_t> found;
  for (pid_t child = 0; file >> child;) found.push_back(child);
  return found;
}

size_t MachineTasks() {
  size_t tasks = 0;
  std::sscanf(TextOf("/proc/loadavg").c_str(), "%*s %*s %*s %*d/%zu", &tasks);
  return tasks;
}

std::vector<pid_t> Family(pid_t root, const std::string& mark) {
  const std::map<pid_t, pid_t> parents = Parents();
  std::set<pid_t> family = {root};
  AddDescendants(parents, family);
  for (const auto& [pid, parent] : parents) {
    if (family.count(pid) == 0 && IsMarked(pid, mark)) family.insert(pid);
  }
  AddDescendants(parents, family);
  return {family.begin(), family.end()};
}

uint64_t PrivateMemory_bytes(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/statm");
  uint64_t size = 0, resident = 0, shared = 0;  // pages
  if (!(file >> size >> resident >> shared) || shared > resident) return 0;
  return (resident - shared) * uint64_t(sysconf(_SC_PAGESIZE));
}

uint64_t MachineMemory_bytes() {
  uint64_t bytes = uint64_t(sysconf(_SC_PHYS_PAGES)) * uint64_t(sysconf(_SC_PAGESIZE));
  for (const char* limit : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    uint64_t allowed = 0;
    if (std::ifstream(limit) >> allowed) bytes = std::min(bytes, allowed);
  }
  return bytes;
}

}  // namespace gaitcam
