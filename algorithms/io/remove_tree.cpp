#include "algorithms/io/remove_tree.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gaitcam {
namespace {

/// A folder by its descriptor, made readable and writable for its owner.
class OpenFolder {
 public:
  OpenFolder(int parent, const std::string& name) {
    fchmodat(parent, name.c_str(), S_IRWXU, 0);
    number_ = openat(parent, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  }
  ~OpenFolder() {
    if (number_ >= 0) close(number_);
  }
  OpenFolder(const OpenFolder&) = delete;
  OpenFolder& operator=(const OpenFolder&) = delete;

  int number() const { return number_; }
  /// Of all that lies in it.
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    const int copy = fcntl(number_, F_DUPFD_CLOEXEC, 0);
    DIR* const listing = copy < 0 ? nullptr : fdopendir(copy);
    if (listing == nullptr) return names;
    rewinddir(listing);  // both have one place in it
    while (const dirent* entry = readdir(listing)) {
      const std::string_view name = entry->d_name;
      if (name != "." && name != "..") names.emplace_back(name);
    }
    closedir(listing);
    return names;
  }

 private:
  int number_ = -1;
};

/// Removes a file, a link or an empty folder.
bool RemoveOne(int folder, const std::string& name) {
  return unlinkat(folder, name.c_str(), 0) == 0 || unlinkat(folder, name.c_str(), AT_REMOVEDIR) == 0;
}

/// Moves the folder `name` of `folder` into `top`, as `.removed-` and the next number after `moved` that is free: a
/// folder takes the name of no file, and of no folder that is not empty.
bool MoveUp(int folder, const std::string& name, int top, uint64_t& moved) {
  for (;;) {
    const std::string next = ".removed-" + std::to_string(++moved);
    if (renameat(folder, name.c_str(), top, next.c_str()) == 0) return true;
    if (errno != EEXIST && errno != ENOTEMPTY && errno != ENOTDIR) return false;
  }
}

/// Removes the folder `name` of `top`, and moves the folders in it that are not empty up into `top`.
/// @returns whether anything was moved or removed.
bool Flatten(int top, const std::string& name, uint64_t& moved) {
  bool any = false;
  {
    const OpenFolder folder(top, name);
    for (const std::string& inner : folder.Names()) {
      if (RemoveOne(folder.number(), inner)) {
        any = true;
        continue;
      }
      fchmodat(folder.number(), inner.c_str(), S_IRWXU, 0);  // its ".." is written to
      any |= MoveUp(folder.number(), inner, top, moved);
    }
  }
  return RemoveOne(top, name) || any;
}

}  // namespace

bool RemoveTree(const std::filesystem::path& path) {
  if (RemoveOne(AT_FDCWD, path.string())) return true;
  {
    const OpenFolder top(AT_FDCWD, path.string());
    uint64_t moved = 0;
    for (bool any = true; any;) {
      any = false;
      for (const std::string& name : top.Names())
        any |= RemoveOne(top.number(), name) || Flatten(top.number(), name, moved);
    }
  }
  std::error_code error;
  return RemoveOne(AT_FDCWD, path.string()) || !std::filesystem::exists(std::filesystem::symlink_status(path, error));
}

}  // namespace gaitcam
