#include "scenarios/code/runs/cache_entry.h"

#include <fstream>
#include <string>

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSize = "bytes";

uintmax_t SizeOfFiles(const fs::path& folder) {
  uintmax_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    if (it->is_regular_file(gone)) bytes += it->file_size(gone);
  }
  return bytes;
}

}  // namespace

fs::path CacheEntryLock(const fs::path& entry) { return entry.string() + ".lock"; }

void NoteCacheEntrySize(const OutputFolder& entry) {
  entry.WriteText(kSize, std::to_string(SizeOfFiles(entry.path())) + "\n");
}

uintmax_t CacheEntrySize(const fs::path& entry) {
  uintmax_t bytes = 0;
  return std::ifstream(entry / kSize) >> bytes ? bytes : SizeOfFiles(entry);
}

}  // namespace gaitcam
