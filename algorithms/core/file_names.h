/// Whether there is a file of a name, where the name comes from a user: one that is too long, or leads through a loop
/// of links or a folder that may not be read, names none. The functions of std::filesystem throw at such.

#pragma once

#include <filesystem>
#include <system_error>

namespace gaitcam {

inline bool IsFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

inline bool IsFolder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

inline bool IsThere(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

}  // namespace gaitcam
