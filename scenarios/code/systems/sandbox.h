/// What somebody else's program may see and reach: the system's folders, its own files, and what it is handed; no
/// truth, no cache, no earlier results, no network, no process of ours. By Debian's `bubblewrap`, where the kernel
/// allows it.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {

struct SandboxView {
  std::vector<std::filesystem::path> readable;  ///< Files and folders, at their own paths.
  std::vector<std::filesystem::path> writable;  ///< Folders.
  std::filesystem::path folder;                 ///< Working folder; one of the writable ones.
};

/// Why no sandbox can be made here, in a few words ("bubblewrap is not installed"); empty if one can.
/// Found out by trying, once per process.
const std::string& WhyNoSandbox();

/// How a program in a sandbox ended, as it would have ended outside: bubblewrap says a signal by an exit code.
Ending EndingIn(const Ending& ending);

/// The words that run `command` in a sandbox: it sees /usr, /etc and the like read-only, an empty home, /tmp and
/// /dev/shm, in memory, an eighth of ForeignMemory_mb(0) each, the packages of the Python that it runs in, and `view`;
/// nowhere else can it write. It ends with us, and all that it started with it. The kernel
/// refuses it more than some 1,000 processes and threads, unless root runs it (Linux 5.14 or later).
/// @param command its first word is a path.
/// @pre WhyNoSandbox().empty().
std::vector<std::string> Sandboxed(const std::vector<std::string>& command, const SandboxView& view);

}  // namespace gaitcam
