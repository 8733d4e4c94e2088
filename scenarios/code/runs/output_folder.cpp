#include "scenarios/code/runs/output_folder.h"

#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

fs::path Clean(const fs::path& path) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& wanted, const std::string& marker)
    : wanted_(Clean(wanted)), temporary_(UnfinishedNameFor(wanted_)) {
  if (fs::exists(wanted_) && !(fs::is_directory(wanted_) && (fs::is_empty(wanted_) || fs::exists(wanted_ / marker)))) {
    throw BadInput("--out " + wanted_.string() + ": exists and holds something else (no " + marker +
                   " in it); name another folder or remove it");
  }
  RemoveAbandoned(wanted_);
  std::error_code error;
  fs::remove_all(temporary_, error);
  for (made_ = temporary_; made_.has_parent_path() && !fs::exists(made_.parent_path());) made_ = made_.parent_path();
  if (!fs::create_directories(temporary_, error) || error) {
    throw MissingResource("cannot create the folder " + temporary_.string() + ": " + error.message());
  }
}

OutputFolder::~OutputFolder() {
  std::error_code error;
  if (committed_) return;
  fs::remove_all(temporary_, error);
  for (fs::path folder = temporary_; folder != made_;) {  // folders made on the way go too, if nothing else is in them
    folder = folder.parent_path();
    fs::remove(folder, error);
  }
}

void OutputFolder::WriteText(const std::string& name, const std::string& text) const {
  WriteWholeFile(temporary_ / name, text);
}

void OutputFolder::Commit() {
  std::error_code error;
  const fs::path aside = temporary_.string() + "-old";  // a name that RemoveAbandoned knows
  if (fs::exists(wanted_)) fs::rename(wanted_, aside, error);
  if (!error) fs::rename(temporary_, wanted_, error);
  if (error) throw MissingResource("cannot move the results to " + wanted_.string() + ": " + error.message());
  committed_ = true;
  fs::remove_all(aside, error);
}

void RemoveUnfinished(const fs::path& wanted) {
  std::error_code error;
  std::vector<fs::path> unfinished;
  for (const auto& item : fs::directory_iterator(wanted.parent_path(), error)) {
    if (item.path().filename().string().starts_with(UnfinishedPrefix(wanted))) unfinished.push_back(item.path());
  }
  for (const fs::path& path : unfinished) fs::remove_all(path, error);
}

}  // namespace gaitcam
