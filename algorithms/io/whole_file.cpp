#include "algorithms/io/whole_file.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/remove_tree.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

std::string MachineName() {
  std::array<char, 64> name{};  // longer ones are cut: a file's name has at most 255 bytes
  if (gethostname(name.data(), name.size() - 1) != 0) return "here";
  return name.data();
}

/// @param owner as NameOfProcess writes it, perhaps with "-" and something behind it.
bool IsGone(std::string_view owner) {
  const std::string here = MachineName() + "-";
  if (!owner.starts_with(here)) return false;
  owner.remove_prefix(here.size());
  pid_t process = 0;
  const auto [end, error] = std::from_chars(owner.data(), owner.data() + owner.size(), process);
  const bool is_whole = end == owner.data() + owner.size() || *end == '-';
  if (error != std::errc() || !is_whole || process <= 0) return false;
  return kill(process, 0) != 0 && errno == ESRCH;
}

/// @returns 0, or the number of the system's error.
int Write(const fs::path& file, std::string_view content) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary);
  stream.write(content.data(), std::streamsize(content.size()));
  stream.close();
  if (stream) return 0;
  return errno ? errno : EIO;
}

/// The file that a name stands for, if need be through symbolic links.
fs::path Followed(const fs::path& file) {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(file, error))) return file;
  const fs::path followed = fs::weakly_canonical(file, error);
  return error ? file : followed;
}

}  // namespace

std::string UnfinishedPrefix(const fs::path& wanted) { return "." + wanted.filename().string() + ".part-"; }

std::string NameOfProcess() { return MachineName() + "-" + std::to_string(getpid()); }

fs::path UnfinishedNameFor(const fs::path& wanted) {
  return wanted.parent_path() / (UnfinishedPrefix(wanted) + NameOfProcess());
}

namespace {

std::vector<fs::path> Abandoned(const fs::path& folder, const std::string& prefix) {
  std::error_code error;
  std::vector<fs::path> abandoned;
  for (const auto& item : fs::directory_iterator(folder, error)) {
    const std::string name = item.path().filename().string();
    if (name.starts_with(prefix) && IsGone(std::string_view(name).substr(prefix.size()))) {
      abandoned.push_back(item.path());
    }
  }
  return abandoned;
}

}  // namespace

void RemoveAbandoned(const fs::path& folder, const std::string& prefix) {
  for (const fs::path& path : Abandoned(folder, prefix)) RemoveTree(path);
}

bool HoldsAbandoned(const fs::path& folder, const std::string& prefix) { return !Abandoned(folder, prefix).empty(); }

void RemoveAbandoned(const fs::path& wanted) {
  RemoveAbandoned(wanted.has_parent_path() ? wanted.parent_path() : ".", UnfinishedPrefix(wanted));
}

namespace {

/// Where the content of a file is to be written first: the place itself, if that is a device.
struct Destination {
  explicit Destination(const fs::path& file) : target(Followed(file)), written(target) {
    std::error_code error;
    const fs::file_status status = fs::status(target, error);
    if (fs::is_directory(status)) throw BadInput(file.string() + ": cannot write this file: it is a folder");
    in_place = fs::exists(status) && !fs::is_regular_file(status);
    if (!in_place) written = UnfinishedNameFor(target);
  }

  fs::path target, written;
  bool in_place = false;
};

}  // namespace

void FailToWrite(const fs::path& file, int error) {
  throw MissingResource(file.string() + ": cannot write this file: " + std::strerror(error != 0 ? error : EIO));
}

void WriteWholeFile(const fs::path& file, std::string_view content) {
  const Destination destination(file);
  if (!destination.in_place) RemoveAbandoned(destination.target);
  int failure = Write(destination.written, content);
  std::error_code error;
  if (!failure && !destination.in_place) {
    fs::rename(destination.written, destination.target, error);
    failure = error.value();
  }
  if (!failure) return;
  if (!destination.in_place) fs::remove(destination.written, error);
  FailToWrite(file, failure);
}

void CheckWritable(const fs::path& file) {
  const Destination destination(file);
  if (destination.in_place) return;
  const int failure = Write(destination.written, "");
  std::error_code ignored;
  fs::remove(destination.written, ignored);
  if (failure) FailToWrite(file, failure);
}

}  // namespace gaitcam
