#include "scenarios/code/files/folders.h"

#include <cstdlib>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace fs = std::filesystem;

fs::path DataFolder() {
  std::vector<fs::path> candidates;
  if (const char* named = std::getenv("GAITCAM_DATA")) candidates.emplace_back(named);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) candidates.push_back(program.parent_path().parent_path().parent_path() / "share/gaitcam");
  candidates.emplace_back(GAITCAM_SOURCE_DIR);
  for (const fs::path& candidate : candidates) {
    if (fs::is_directory(candidate / "models")) return candidate;
  }
  throw MissingResource("no folder with robots and scenes was found; set GAITCAM_DATA to the one that holds `models`");
}

fs::path ModelsFolder() { return DataFolder() / "models"; }

}  // namespace gaitcam
