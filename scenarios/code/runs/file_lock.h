/// Processes that share a folder take turns by locks on files.

#pragma once

#include <filesystem>
#include <functional>
#include <optional>

namespace gaitcam {

/// A file lock that lasts as long as the object; other processes wait for it.
class FileLock {
 public:
  enum class Kind { kShared, kExclusive };
  /// @throws MissingResource if the file cannot be made or locked.
  FileLock(const std::filesystem::path& file, Kind kind);
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;

  /// An exclusive lock, if that needs no waiting. @throws MissingResource if the file cannot be made.
  static std::optional<FileLock> Try(const std::filesystem::path& file);
  /// Locks only if that needs no waiting. @returns whether it did.
  static bool TryExclusive(const std::filesystem::path& file, const std::function<void()>& then);

 private:
  FileLock() = default;
  int descriptor_ = -1;
};

}  // namespace gaitcam
