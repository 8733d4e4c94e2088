/// A folder of results that appears whole or not at all.

#pragma once

#include <filesystem>
#include <string>

namespace gaitcam {

/// Collects files under a temporary name beside the wanted one; Commit() renames it. What was not committed is removed.
class OutputFolder {
 public:
  /// @param marker a file that every folder of this kind holds: an older folder is replaced only if it has it.
  /// @throws BadInput if `wanted` exists and is something else; MissingResource if it cannot be written.
  OutputFolder(const std::filesystem::path& wanted, const std::string& marker);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write until Commit().
  const std::filesystem::path& path() const { return temporary_; }
  /// @throws MissingResource if the file cannot be written whole.
  void WriteText(const std::string& name, const std::string& text) const;
  /// Gives the folder its name, in place of an older one.
  void Commit();

 private:
  const std::filesystem::path wanted_, temporary_;
  std::filesystem::path made_;  ///< The first folder on the way that was not there before.
  bool committed_ = false;
};

/// Removes what killed processes left of output folders of this name. The caller knows that none is being written.
void RemoveUnfinished(const std::filesystem::path& wanted);

}  // namespace gaitcam
