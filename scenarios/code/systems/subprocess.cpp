#include "scenarios/code/systems/subprocess.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_names.h"
#include "scenarios/code/systems/foreign_words.h"
#include "scenarios/code/systems/process_list.h"

extern char** environ;

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kMarkName = "GAITCAM_STARTED_BY";

/// Between fork and exec; nothing here may take a lock that another thread held.
[[noreturn]] void BecomeProgram(char* const* words, char* const* environment, const SubprocessStreams& streams,
                                pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(126);  // it died before we could say so
  setpgid(0, 0);
  const int log = open(streams.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  const int input = streams.input >= 0 ? streams.input : open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (input >= 0) dup2(input, STDIN_FILENO);
  if (streams.output >= 0) {
    dup2(streams.output, STDOUT_FILENO);
  } else if (log >= 0) {
    dup2(log, STDOUT_FILENO);
  }
  if (log >= 0) dup2(log, STDERR_FILENO);
  if (!streams.folder.empty() && chdir(streams.folder.c_str()) != 0) _exit(126);
  if (streams.max_file_bytes > 0) {
    const rlimit limit = {streams.max_file_bytes, streams.max_file_bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  close_range(3, ~0U, 0);
  execvpe(words[0], words, environment);
  _exit(127);
}

std::vector<char*> Pointers(const std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// Ours and `more`, with `mark` added to the marks of those who started us.
std::vector<std::string> MarkedEnvironment(const std::string& mark, const std::map<std::string, std::string>& more) {
  std::vector<std::string> environment;
  std::string marks;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    if (text.starts_with(std::string(kMarkName) + "=")) {
      marks = text.substr(kMarkName.size() + 1);
    } else {
      environment.emplace_back(text);
    }
  }
  for (const auto& [name, value] : more) {
    if (std::getenv(name.c_str()) == nullptr) environment.push_back(name + "=" + value);
  }
  environment.push_back(fmt::format("{}={}{}", kMarkName, marks, mark));
  return environment;
}

/// Which children of ours are known: those that we started and wait for, and those that this process had from the
/// start. Any other was left behind by a program that has ended, and came to us because we asked the kernel for such.
class KnownChildren {
 public:
  static KnownChildren& Instance() {
    static KnownChildren instance;
    return instance;
  }
  /// Forks; `begin` goes on in the child. @returns its number, or -1.
  template <class Begin>
  pid_t Fork(Begin begin) {
    const std::lock_guard lock(mutex_);  // a child is known from its first moment
    const pid_t child = fork();
    if (child == 0) begin();
    if (child > 0) known_.insert(child);
    return child;
  }
  void Forget(pid_t child) {
    const std::lock_guard lock(mutex_);
    known_.erase(child);
  }
  /// Kills all others. @returns whether there was one.
  bool KillOthers() {
    if (!adopts_) return false;
    const std::lock_guard lock(mutex_);
    bool any = false;
    for (const pid_t child : Children()) {
      if (known_.count(child) != 0) continue;
      any |= kill(child, SIGKILL) == 0;
      waitpid(child, nullptr, 0);
    }
    return any;
  }

 private:
  KnownChildren() {
    for (const pid_t child : Children()) known_.insert(child);  // of who became us by exec
    const bool is_first = getpid() == 1;                        // of a container: everybody's orphans come to it anyway
    adopts_ = !is_first && prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
  }
  std::mutex mutex_;
  std::set<pid_t> known_;
  bool adopts_ = false;
};

}  // namespace

std::string Ending::ToText() const {
  if (!offence.empty()) return (signal == SIGKILL ? "was killed: " : "ended by itself, but ") + offence;
  return signal == 0 ? fmt::format("exited with {}", code)
                     : fmt::format("died of signal {} ({})", signal, strsignal(signal));
}

Subprocess::Subprocess(const std::vector<std::string>& command, const SubprocessStreams& streams) {
  GAITCAM_ASSERT(!command.empty());
  static std::atomic<int> count = 0;
  const pid_t parent = getpid();
  mark_ = fmt::format("<{}.{}.{}>", parent, std::chrono::steady_clock::now().time_since_epoch().count(), ++count);
  const std::vector<std::string> environment = MarkedEnvironment(mark_, streams.variables);
  const std::vector<char*> words = Pointers(command), variables = Pointers(environment);
  child_ = KnownChildren::Instance().Fork([&] { BecomeProgram(words.data(), variables.data(), streams, parent); });
  if (child_ < 0) throw MissingResource(std::string("cannot start another process: ") + std::strerror(errno));
  setpgid(child_, child_);  // whichever of us comes first
  FamilyLimits limits;
  if (streams.max_memory_mb > 0) limits.memory_bytes = uint64_t(streams.max_memory_mb * 1e6);
  if (streams.max_processes > 0) limits.processes = streams.max_processes;
  if (!streams.folder.empty() && (streams.max_folder_bytes > 0 || streams.max_folder_files > 0)) {
    limits.folder = streams.folder;
    if (streams.max_folder_bytes > 0) limits.folder_bytes = streams.max_folder_bytes;
    if (streams.max_folder_files > 0) limits.folder_files = streams.max_folder_files;
  }
  if (streams.max_memory_mb > 0 || streams.max_processes > 0 || !limits.folder.empty())
    watch_ = std::make_unique<FamilyWatch>(child_, mark_, limits);
}

Subprocess::~Subprocess() {
  if (child_ == 0) return;
  watch_.reset();  // before its number may be another's
  kill(-child_, SIGKILL);
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
  KnownChildren::Instance().Forget(child_);
  KillDescendants();
}

Subprocess::Subprocess(Subprocess&& other) noexcept
    : child_(std::exchange(other.child_, 0)),
      mark_(std::move(other.mark_)),
      watch_(std::move(other.watch_)),
      ending_(std::move(other.ending_)) {}

/// Again until there is none: one may start another while we look.
void Subprocess::KillDescendants() const {
  constexpr int kMaxRounds = 20;
  for (int round = 0; round < kMaxRounds; ++round) {
    bool any = false;
    for (const pid_t pid : Marked(mark_)) any |= kill(pid, SIGKILL) == 0;
    any |= KnownChildren::Instance().KillOthers();
    if (!any) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::optional<Ending> Subprocess::Poll() {
  if (ending_) return ending_;
  siginfo_t info = {};
  if (waitid(P_PID, id_t(child_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != child_)
    return std::nullopt;
  const std::string killed_for = watch_ ? watch_->KilledFor() : "", left_behind = watch_ ? watch_->LeftBehind() : "";
  watch_.reset();  // as long as its number is its own
  int status = 0;
  waitpid(child_, &status, 0);
  kill(-child_, SIGKILL);
  KnownChildren::Instance().Forget(child_);
  KillDescendants();
  child_ = 0;
  ending_ = WIFEXITED(status) ? Ending{WEXITSTATUS(status), 0} : Ending{-1, WTERMSIG(status)};
  if (!killed_for.empty()) {
    ending_ = Ending{-1, SIGKILL, killed_for};
  } else {
    ending_->offence = left_behind;
  }
  return ending_;
}

std::optional<Ending> Subprocess::Wait(double seconds) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  while (!Poll()) {
    if (Clock::now() >= end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return ending_;
}

std::optional<fs::path> FindProgram(const std::string& name) {
  const auto is_program = [](const fs::path& file) { return access(file.c_str(), X_OK) == 0 && !IsFolder(file); };
  if (name.find('/') != std::string::npos) return is_program(name) ? std::optional<fs::path>(name) : std::nullopt;
  const char* path = std::getenv("PATH");
  std::stringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && is_program(fs::path(folder) / name)) return fs::path(folder) / name;
  }
  return std::nullopt;
}

double ForeignMemory_mb(double given) {
  constexpr double kPart = 0.75;
  return given > 0 ? given : kPart * double(MachineMemory_bytes()) / 1e6;
}

std::string LastLine(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  constexpr std::streamoff kMost = 64 << 10;
  if (const std::streamoff size = stream.tellg(); size >= 0) stream.seekg(std::max<std::streamoff>(0, size - kMost));
  std::string line, last;
  while (std::getline(stream, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") != std::string::npos) last = line;
  }
  return ForeignWords(last);
}

}  // namespace gaitcam
