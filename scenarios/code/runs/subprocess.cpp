#include "scenarios/code/runs/subprocess.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Between fork and exec; nothing here may take a lock that another thread held.
[[noreturn]] void BecomeProgram(char* const* words, const char* output, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(126);  // it died before we could say so
  setpgid(0, 0);
  const int out = open(output, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out >= 0) {
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
  }
  execvp(words[0], words);
  _exit(127);
}

}  // namespace

std::string Ending::ToText() const {
  return signal == 0 ? fmt::format("exited with {}", code)
                     : fmt::format("died of signal {} ({})", signal, strsignal(signal));
}

Subprocess::Subprocess(const std::vector<std::string>& command, const std::filesystem::path& output_file) {
  GAITCAM_ASSERT(!command.empty());
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  const pid_t parent = getpid();
  child_ = fork();
  if (child_ == 0) BecomeProgram(words.data(), output_file.c_str(), parent);
  if (child_ < 0) throw MissingResource(std::string("cannot start another process: ") + std::strerror(errno));
  setpgid(child_, child_);  // whichever of us comes first
}

Subprocess::~Subprocess() {
  if (child_ == 0) return;
  kill(-child_, SIGKILL);
  kill(child_, SIGKILL);
  waitpid(child_, nullptr, 0);
}

Subprocess::Subprocess(Subprocess&& other) noexcept
    : child_(std::exchange(other.child_, 0)), ending_(std::move(other.ending_)) {}

std::optional<Ending> Subprocess::Poll() {
  if (ending_) return ending_;
  int status = 0;
  if (waitpid(child_, &status, WNOHANG) != child_) return std::nullopt;
  kill(-child_, SIGKILL);  // what it started and left behind
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

bool IsProgram(const std::string& name) {
  if (name.find('/') != std::string::npos) return access(name.c_str(), X_OK) == 0;
  const char* path = std::getenv("PATH");
  std::stringstream folders(path == nullptr ? "" : path);
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    if (!folder.empty() && access((std::filesystem::path(folder) / name).c_str(), X_OK) == 0) return true;
  }
  return false;
}

std::string LastLine(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

}  // namespace gaitcam
