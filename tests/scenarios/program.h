/// Runs the built program as a user would, and keeps what it says.

#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace gaitcam {

inline std::string ReadAll(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

struct ProgramResult {
  int exit_code = -1;
  std::string out, err;
};

/// @param arguments words as a shell splits them; `folder` is the working folder and receives the two streams.
inline ProgramResult RunProgram(const std::string& arguments, const std::filesystem::path& folder) {
  const std::string command = "cd " + folder.string() + " && GAITCAM_DATA=" GAITCAM_SOURCE_DIR " " GAITCAM_PROGRAM " " +
                              arguments + " >.out 2>.err";
  ProgramResult result;
  const int status = std::system(command.c_str());
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = ReadAll(folder / ".out");
  result.err = ReadAll(folder / ".err");
  std::filesystem::remove(folder / ".out");
  std::filesystem::remove(folder / ".err");
  return result;
}

}  // namespace gaitcam
