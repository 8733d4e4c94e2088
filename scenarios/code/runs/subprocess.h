/// Another program, started with its words captured; it does not outlive us.

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gaitcam {

/// How a program ended.
struct Ending {
  int code = 0;    ///< Exit code; -1 if a signal ended it.
  int signal = 0;  ///< 0 unless a signal ended it.

  bool ok() const { return code == 0; }
  /// "exited with 3", "died of signal 11 (Segmentation fault)".
  std::string ToText() const;
};

class Subprocess {
 public:
  /// Starts a program, looked for in PATH unless its name has a "/"; standard output and error go to `output_file`.
  /// It leads a process group of its own: Ctrl-C is ours to handle. It is killed when the starting thread dies.
  /// A program that cannot be started ends with code 127.
  /// @throws MissingResource if no process can be made.
  Subprocess(const std::vector<std::string>& command, const std::filesystem::path& output_file);
  /// Kills it, with all that it started, if it still runs.
  ~Subprocess();
  Subprocess(Subprocess&& other) noexcept;
  Subprocess& operator=(Subprocess&&) = delete;

  /// How it ended, if it has.
  std::optional<Ending> Poll();
  /// Waits for its end. @returns nothing if the time is up first.
  std::optional<Ending> Wait(double seconds);

 private:
  pid_t child_ = 0;  ///< 0: ended, or moved from.
  std::optional<Ending> ending_;
};

/// Whether there is such a program: in PATH unless its name has a "/".
bool IsProgram(const std::string& name);

/// The last line of a text file that is not blank; empty if there is none.
std::string LastLine(const std::filesystem::path& file);

}  // namespace gaitcam
