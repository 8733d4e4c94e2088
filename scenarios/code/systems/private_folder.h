/// A folder for us and one program that we start; its name tells nothing of where results or truth lie.

#pragma once

#include <filesystem>

namespace gaitcam {

/// Removed with the object, whatever lies in it then; or by the next one, where a process was killed that had it.
class PrivateFolder {
 public:
  /// Below the folder for temporary files. @throws MissingResource if it cannot be made.
  PrivateFolder() : PrivateFolder(std::filesystem::temp_directory_path()) {}
  /// In memory where the machine has /dev/shm, else as above.
  static PrivateFolder InMemory();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit PrivateFolder(const std::filesystem::path& parent);

  std::filesystem::path path_;
};

}  // namespace gaitcam
