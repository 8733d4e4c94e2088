/// Another program, started with its words captured; it does not outlive us.

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/code/systems/family_watch.h"

namespace gaitcam {

/// How a program ended.
struct Ending {
  int code = 0;              ///< Exit code; -1 if a signal ended it.
  int signal = 0;            ///< 0 unless a signal ended it.
  std::string offence = {};  ///< "it took more than 500 MB of memory"; then it was killed, if it had not ended.

  bool ok() const { return code == 0 && offence.empty(); }
  /// "exited with 3", "died of signal 11 (Segmentation fault)", "was killed: it took more than 500 MB of memory",
  /// "ended by itself, but it wrote more than 10000 files".
  std::string ToText() const;
};

/// What a program starts with. Of our open files it inherits these alone.
struct SubprocessStreams {
  std::filesystem::path log;          ///< Receives standard error, and standard output unless that is given.
  int input = -1;                     ///< Standard input; -1: empty.
  int output = -1;                    ///< Standard output; -1: the log.
  std::filesystem::path folder = {};  ///< Working folder; empty: ours.
  std::map<std::string, std::string> variables = {};  ///< Of its environment, where ours says nothing of them.
  size_t max_file_bytes = 0;                          ///< Of each file that it writes, its log too; 0: no limit.
  double max_memory_mb = 0;                           ///< Of it and all that it starts, together; 0: no limit.
  size_t max_processes = 0;                           ///< Likewise.
  uint64_t max_folder_bytes = 0;                      ///< Of all files below `folder`; 0: no limit.
  size_t max_folder_files = 0;                        ///< Likewise, folders too.
};

class Subprocess {
 public:
  /// Starts a program, looked for in PATH unless its name has a "/". It leads a process group of its own: Ctrl-C is
  /// ours to handle. It is killed when the starting thread dies. A program that cannot be started ends with code 127.
  /// @throws MissingResource if no process can be made.
  Subprocess(const std::vector<std::string>& command, const SubprocessStreams& streams);
  Subprocess(const std::vector<std::string>& command, const std::filesystem::path& log)
      : Subprocess(command, SubprocessStreams{log}) {}
  /// Kills it if it still runs, with all that it started: process groups and sessions of their own included, and those
  /// with an environment of their own, whose parent has gone (they become children of ours).
  ~Subprocess();
  Subprocess(Subprocess&& other) noexcept;
  Subprocess& operator=(Subprocess&&) = delete;

  /// How it ended, if it has. What it started and left behind is killed then.
  std::optional<Ending> Poll();
  /// Waits for its end. @returns nothing if the time is up first.
  std::optional<Ending> Wait(double seconds);

 private:
  void KillDescendants() const;

  pid_t child_ = 0;                     ///< 0: ended, or moved from.
  std::string mark_;                    ///< In the environment of all that it starts.
  std::unique_ptr<FamilyWatch> watch_;  ///< Nothing where there is no limit.
  std::optional<Ending> ending_;
};

/// The file of a program: the name itself if it has a "/", else the first in PATH. Nothing if it may not be executed.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

/// No file of somebody else's program grows beyond this: its folder lies in memory, and what it printed is kept.
constexpr size_t kMaxForeignFile_bytes = size_t(1) << 30;

/// All that it writes into its folder, together.
constexpr uint64_t kMaxForeignFolder_bytes = 4'000'000'000;
constexpr size_t kMaxForeignFiles = 10'000;

/// Nobody's odometry needs as many processes; a program that forks without end is stopped by it.
constexpr size_t kMaxForeignProcesses = 500;

/// What somebody else's program may take of memory: `given`, or three quarters of the machine's if that is 0.
double ForeignMemory_mb(double given);

/// The last line of a text file that is not blank, as ForeignWords; empty if there is none in the last 64 KiB.
std::string LastLine(const std::filesystem::path& file);

}  // namespace gaitcam
