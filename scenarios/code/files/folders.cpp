#include "scenarios/code/files/folders.h"

#include <algorithm>
#include <cstdlib>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/file_names.h"

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

bool IsInstalled() { return !fs::exists(DataFolder() / "CMakeLists.txt"); }

std::vector<std::string> ShippedNames(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(DataFolder() / folder, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path UsersOrShipped(const fs::path& named, const std::vector<std::string>& folders) {
  if (named.empty() || named.is_absolute() || IsThere(named)) return named;
  if (named.has_extension() || named.has_parent_path()) {
    const fs::path shipped = DataFolder() / named;
    return named.begin()->string() == "scenarios" && IsFile(shipped) ? shipped : named;
  }
  std::vector<std::string> known;
  for (const std::string& folder : folders) {
    for (const std::string& name : ShippedNames(folder)) {
      if (name == named) return DataFolder() / folder / (name + ".yaml");
      known.push_back(name);
    }
  }
  throw BadInput(named.string() + ": neither a file nor the name of a shipped one; " +
                 DidYouMean(named.string(), known, "see gaitcam list"));
}

void CheckFileName(const OptionValue& node, const std::string& key, const std::string& name) {
  constexpr size_t kLongest = 100;
  const auto is_bad = [](unsigned char c) { return c == '/' || c < ' ' || c == 127; };
  const bool is_good = !name.empty() && name.size() <= kLongest && name != "." && name != ".." &&
                       std::none_of(name.begin(), name.end(), is_bad);
  if (is_good) return;
  (node.Has(key) ? node.Child(key) : node)
      .Fail(R"(files are named after this; expected 1 to 100 characters, no "/" and no line feed among them, )"
            R"(and not "." or "..")");
}

}  // namespace gaitcam
