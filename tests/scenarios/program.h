/// Runs the built program as a user would, and keeps what it says.

#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {

/// The program under test: the installed one where the launcher names it, else the one that was built beside the tests.
inline std::string Program() {
  const char* named = std::getenv("GAITCAM_PROGRAM");
  return named != nullptr ? named : GAITCAM_PROGRAM;
}

struct ProgramResult {
  int exit_code = -1;
  std::string out, err;
};

/// @param command line of a shell; `folder` is the working folder and receives the two streams.
inline ProgramResult RunShell(const std::string& command, const std::filesystem::path& folder) {
  ProgramResult result;
  const int status = std::system(("cd " + folder.string() + " && { " + command + "; } >.out 2>.err").c_str());
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = ReadText(folder / ".out");
  result.err = ReadText(folder / ".err");
  std::filesystem::remove(folder / ".out");
  std::filesystem::remove(folder / ".err");
  return result;
}

/// @param arguments words as a shell splits them; `folder` is the working folder and receives the two streams.
inline ProgramResult RunProgram(const std::string& arguments, const std::filesystem::path& folder) {
  return RunShell("GAITCAM_DATA=" + TestData().string() + " " + Program() + " " + arguments, folder);
}

}  // namespace gaitcam
