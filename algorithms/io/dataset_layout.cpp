#include "algorithms/io/dataset_layout.h"

#include <algorithm>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

bool IsEuroc(const fs::path& folder) { return fs::exists(folder / "mav0" / "cam0" / "data.csv"); }
bool IsTum(const fs::path& folder) { return fs::exists(folder / "rgb.txt"); }

}  // namespace

std::string ToString(DatasetFormat format) { return std::string(ToWord(format)); }

DatasetFormat DatasetFormatFromText(const std::string& text) {
  for (const auto format : {DatasetFormat::kTum, DatasetFormat::kEuroc}) {
    if (text == ToString(format)) return format;
  }
  throw BadInput("dataset format " + text + ": expected one of tum, euroc");
}

DatasetFolders DatasetFolders::In(const fs::path& out, const std::string& name) {
  return {out / name, out / (name + "-truth")};
}

fs::path FindDataset(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw BadInput(folder.string() + ": there is no such folder");
  if (IsEuroc(folder) || IsTum(folder)) return folder;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && (IsEuroc(entry.path()) || IsTum(entry.path()))) found.push_back(entry.path());
  }
  if (found.size() == 1) return found[0];
  if (found.empty()) {
    throw BadInput(folder.string() + ": is no dataset; expected rgb.txt (TUM RGB-D) or mav0/cam0/data.csv (EuRoC ASL)");
  }
  std::sort(found.begin(), found.end());
  throw BadInput(folder.string() + ": holds several datasets; say which, for example " + found[0].string());
}

DatasetFormat FormatOfDataset(const fs::path& folder) {
  if (IsEuroc(folder)) return DatasetFormat::kEuroc;
  if (IsTum(folder)) return DatasetFormat::kTum;
  throw BadInput(folder.string() + ": is no dataset; expected rgb.txt (TUM RGB-D) or mav0/cam0/data.csv (EuRoC ASL)");
}

}  // namespace gaitcam
