#include "scenarios/code/runs/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace fs = std::filesystem;

FileLock::FileLock(const fs::path& file, Kind kind)
    : descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  int result = -1;
  if (descriptor_ >= 0) {
    do {
      result = flock(descriptor_, kind == Kind::kShared ? LOCK_SH : LOCK_EX);
    } while (result != 0 && errno == EINTR);
  }
  if (result == 0) return;
  const std::string reason = std::strerror(errno);
  if (descriptor_ >= 0) close(descriptor_);
  throw MissingResource("cannot lock " + file.string() + ": " + reason);
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

std::optional<FileLock> FileLock::Try(const fs::path& file) {
  FileLock lock;
  lock.descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock.descriptor_ < 0) throw MissingResource("cannot lock " + file.string() + ": " + std::strerror(errno));
  if (flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) return std::nullopt;
  return lock;
}

bool FileLock::TryExclusive(const fs::path& file, const std::function<void()>& then) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  if (locked) then();
  close(descriptor);
  return locked;
}

}  // namespace gaitcam
