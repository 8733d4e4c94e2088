/// What is true of a recording, in a folder of its own beside the sensors' (`dataset_layout.h`).

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/frame_truth.h"
#include "algorithms/io/dataset_files.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

/// The part of a recording that no SLAM system is given. Functions that write throw MissingResource.
class TruthFiles {
 public:
  /// @param calibration the right one. @param inside the sensors' folder, where the layout's own table of poses is
  /// wanted there, too.
  /// @throws BadInput if the folder exists already.
  TruthFiles(const std::filesystem::path& folder, DatasetFormat format, const Calibration& calibration,
             const std::optional<std::filesystem::path>& inside);

  /// One frame's. Images are written by `jobs`.
  void Add(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs);
  /// A file of this text.
  void AddText(const std::string& name, const std::string& text) const { WriteText(folder_.path() / name, text); }

  /// Gives the folder its name, with a mark in it until Keep().
  void Finish(int64_t frames, const std::string& ending);
  /// The sensors' folder has its name, too.
  void Keep();

 private:
  void AddLayoutsOwn(const std::filesystem::path& root);
  void AddPoses(const std::filesystem::path& root);
  void AddStates(const std::filesystem::path& root);
  void AddImages(int64_t stamp_ns, const FilmedTruth& truth, ImageJobs& jobs);

  DatasetFormat format_;
  Calibration calibration_;
  PendingFolder folder_;
  std::vector<RowFile> poses_, states_, rows_;  ///< TUM's, EuRoC's, VSLAM-LAB's.
  RowFile frames_, subposes_;
  std::optional<ImageFiles> sharp_, depth_, blur_;
};

/// Removes what a process left that was killed after TruthFiles::Finish() and before Keep(). @returns the folders.
const DatasetFolders& WithoutHalfNamed(const DatasetFolders& folders);

}  // namespace gaitcam
