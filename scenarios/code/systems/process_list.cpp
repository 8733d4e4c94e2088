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

/// What each process has in a file of its folder in /proc; empty where it may not be read.
std::map<pid_t, std::string> FilesOfProcesses(const char* file_name) {
  std::map<pid_t, std::string> files;
  std::error_code ignored;
  for (fs::directory_iterator entry("/proc", ignored), end; entry != end; entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    pid_t pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ec != std::errc()) continue;
    files[pid] = TextOf(entry->path() / file_name);
  }
  return files;
}

std::map<pid_t, pid_t> Parents() {
  std::map<pid_t, pid_t> parents;
  for (const auto& [pid, text] : FilesOfProcesses("stat")) {
    const size_t name_end = text.rfind(')');  // "pid (name) state parent ..."
    int parent = 0;
    if (name_end != std::string::npos && std::sscanf(text.c_str() + name_end, ") %*c %d", &parent) == 1) {
      parents[pid] = parent;
    }
  }
  return parents;
}

}  // namespace

std::vector<pid_t> Marked(const std::string& mark) {
  std::vector<pid_t> found;
  for (const auto& [pid, environment] : FilesOfProcesses("environ")) {
    if (environment.find(mark) != std::string::npos) found.push_back(pid);
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

std::vector<pid_t> Family(pid_t root, const std::string& mark) {
  const std::vector<pid_t> marked = Marked(mark);
  std::set<pid_t> family(marked.begin(), marked.end());
  family.insert(root);
  const std::map<pid_t, pid_t> parents = Parents();
  for (size_t before = 0; before != family.size();) {
    before = family.size();
    for (const auto& [pid, parent] : parents) {
      if (family.count(parent) != 0) family.insert(pid);
    }
  }
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
