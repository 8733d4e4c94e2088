#include "scenarios/code/systems/sandbox.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// Of the operating system: programs and libraries, and no data of users.
constexpr std::array kSystemFolders = {"/usr",   "/bin", "/sbin", "/lib", "/lib32",
                                       "/lib64", "/etc", "/opt",  "/nix", "/sys"};
constexpr std::array kDevices = {"/dev/dri", "/dev/nvidia0", "/dev/nvidiactl", "/dev/nvidia-uvm"};

bool IsBelow(const fs::path& path, const fs::path& folder) {
  const fs::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

bool IsOfSystem(const fs::path& path) {
  for (const char* folder : kSystemFolders) {
    if (IsBelow(path, folder)) return true;
  }
  return false;
}

fs::path Home() {
  const char* home = std::getenv("HOME");
  return home == nullptr || *home != '/' ? fs::path() : fs::path(home).lexically_normal();
}

/// The installation of Python that a program is of (an environment, or a folder of pyenv's), if it is: without it
/// the program finds none of its packages. Never the folder of a user's own files.
fs::path PythonOf(const fs::path& program) {
  const fs::path prefix = program.parent_path().parent_path();
  if (prefix.empty() || prefix == Home() || prefix == "/") return {};
  std::error_code ignored;
  if (fs::exists(prefix / "pyvenv.cfg", ignored) || fs::exists(prefix / "conda-meta", ignored)) return prefix;
  if (program.parent_path().filename() == "shims" && fs::exists(prefix / "versions", ignored)) return prefix;
  if (prefix.parent_path().filename() == "versions" && program.filename().string().starts_with("python")) return prefix;
  return {};
}

/// A program that is not of the system, with the Python that it needs and, where it is a link, its target.
std::vector<fs::path> FilesOfProgram(const fs::path& program) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::path& file : {fs::absolute(program).lexically_normal(), fs::weakly_canonical(program, ignored)}) {
    if (IsOfSystem(file)) continue;
    const fs::path python = PythonOf(file);
    files.push_back(python.empty() ? file : python);
  }
  return files;
}

/// An empty folder in memory, of limited size: what lies in it is of no process, so that no limit of memory sees it.
std::vector<std::string> FolderInMemory(const fs::path& folder) {
  constexpr double kPart = 1.0 / 8, kBytesPerMb = 1e6;
  const uint64_t bytes = uint64_t(kPart * kBytesPerMb * ForeignMemory_mb(0));
  return {"--size", std::to_string(bytes), "--tmpfs", folder.string()};
}

std::vector<std::string> BubblewrapWords() {
  std::vector<std::string> words = {"bwrap", "--unshare-all", "--die-with-parent", "--new-session", "--proc", "/proc",
                                    "--dev", "/dev"};
  for (const char* folder : {"/dev/shm", "/tmp"}) {
    for (const std::string& word : FolderInMemory(folder)) words.push_back(word);
  }
  for (const char* folder : kSystemFolders) words.insert(words.end(), {"--ro-bind-try", folder, folder});
  for (const char* device : kDevices) words.insert(words.end(), {"--dev-bind-try", device, device});
  return words;
}

/// Whether limits of processes hold in a sandbox alone; before, they count all that the user runs.
bool KernelCountsTasksPerNamespace() {
  utsname kernel = {};
  int major = 0, minor = 0;
  if (uname(&kernel) != 0 || std::sscanf(kernel.release, "%d.%d", &major, &minor) != 2) return false;
  return std::pair(major, minor) >= std::pair(5, 14);
}

/// The words before a program in a sandbox by which it has no more processes and threads than it may, however fast it
/// starts them. The limit has no effect where root runs it.
std::vector<std::string> TaskLimitWords() {
  // Numerical libraries start a thread for each processor, and several of them in one program do so each.
  constexpr size_t kThreadsPerProcessor = 8;
  const std::optional<fs::path> prlimit = FindProgram("prlimit");
  rlimit ours = {};
  if (!prlimit || !KernelCountsTasksPerNamespace() || getrlimit(RLIMIT_NPROC, &ours) != 0) return {};
  const size_t threads = kThreadsPerProcessor * std::thread::hardware_concurrency();
  const rlim_t tasks = kMaxForeignProcesses + std::max(kMaxForeignProcesses, threads);
  return {prlimit->string(), fmt::format("--nproc={}", std::min(tasks, ours.rlim_cur))};
}

std::string TrySandbox() {
  if (!FindProgram("bwrap")) return "bubblewrap is not installed";
  Subprocess program(Sandboxed({"/bin/true"}, {{}, {}, "/tmp"}), fs::path("/dev/null"));
  constexpr double kLimit_s = 10;
  const std::optional<Ending> ending = program.Wait(kLimit_s);
  return ending && ending->ok() ? "" : "the kernel does not let bubblewrap make one";
}

}  // namespace

const std::string& WhyNoSandbox() {
  static const std::string why = TrySandbox();
  return why;
}

Ending EndingIn(const Ending& ending) {
  if (!ending.offence.empty()) return ending;
  constexpr int kSignals = 128, kMaxSignal = 64;
  const bool is_signal = WhyNoSandbox().empty() && ending.code > kSignals && ending.code <= kSignals + kMaxSignal;
  return is_signal ? Ending{-1, ending.code - kSignals} : ending;
}

std::vector<std::string> Sandboxed(const std::vector<std::string>& command, const SandboxView& view) {
  std::vector<std::string> words = BubblewrapWords();
  const auto show = [&](const char* how, const fs::path& path) {
    words.insert(words.end(), {how, path.string(), path.string()});
  };
  if (const fs::path home = Home(); home.empty() || home == "/") {
    words.insert(words.end(), {"--setenv", "HOME", "/tmp"});
  } else if (!IsOfSystem(home)) {
    for (const std::string& word : FolderInMemory(home)) words.push_back(word);
    show("--ro-bind-try", home / ".local/lib");  // packages that pip installed for the user
  }
  for (const fs::path& file : FilesOfProgram(command.front())) show("--ro-bind-try", file);
  for (const fs::path& path : view.readable) show("--ro-bind", path);
  for (const fs::path& path : view.writable) show("--bind", path);
  // The folders that hold all these lie in memory, too.
  words.insert(words.end(), {"--remount-ro", "/dev", "--remount-ro", "/", "--chdir", view.folder.string(), "--"});
  const std::vector<std::string> limit = TaskLimitWords();
  words.insert(words.end(), limit.begin(), limit.end());
  words.insert(words.end(), command.begin(), command.end());
  return words;
}

}  // namespace gaitcam
