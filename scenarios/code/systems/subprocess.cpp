#include "scenarios/code/systems/subprocess.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

#include "algorithms/core/errors.h"

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

/// Processes whose environment holds the mark. Those of other users cannot be read.
std::vector<pid_t> Marked(const std::string& mark) {
  std::vector<pid_t> marked;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string name = entry.path().filename().string();
    pid_t pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ec != std::errc()) continue;
    std::ifstream file(entry.path() / "environ", std::ios::binary);
    const std::string environment{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (environment.find(mark) != std::string::npos) marked.push_back(pid);
  }
  return marked;
}

}  // namespace

std::string Ending::ToText() const {
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
  child_ = fork();
  if (child_ == 0) BecomeProgram(words.data(), variables.data(), streams, parent);
  if (child_ < 0) throw MissingResource(std::string("cannot start another process: ") + std::strerror(errno));
  setpgid(child_, child_);  // whichever of us comes first
}

Subprocess::~Subprocess() {
  if (child_ == 0) return;
  kill(-child_, SIGKILL);
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
  KillDescendants();
}

Subprocess::Subprocess(Subprocess&& other) noexcept
    : child_(std::exchange(other.child_, 0)), mark_(std::move(other.mark_)), ending_(other.ending_) {}

/// Again until there is none: one may start another while we look.
void Subprocess::KillDescendants() const {
  constexpr int kMaxRounds = 20;
  for (int round = 0; round < kMaxRounds; ++round) {
    bool any = false;
    for (const pid_t pid : Marked(mark_)) any |= kill(pid, SIGKILL) == 0;
    if (!any) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::optional<Ending> Subprocess::Poll() {
  if (ending_) return ending_;
  int status = 0;
  if (waitpid(child_, &status, WNOHANG) != child_) return std::nullopt;
  kill(-child_, SIGKILL);
  KillDescendants();
  child_ = 0;
  ending_ = WIFEXITED(status) ? Ending{WEXITSTATUS(status), 0} : Ending{-1, WTERMSIG(status)};
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
  const auto is_program = [](const fs::path& file) {
    return access(file.c_str(), X_OK) == 0 && !fs::is_directory(file);
  };
  if (name.find('/') != std::string::npos) return is_program(name) ? std::optional<fs::path>(name) : std::nullopt;
  const char* path = std::getenv("PATH");
  std::stringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && is_program(fs::path(folder) / name)) return fs::path(folder) / name;
  }
  return std::nullopt;
}

std::string LastLine(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

}  // namespace gaitcam
