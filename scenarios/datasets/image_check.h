/// Whether a table of images and the images it lists are whole.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "scenarios/datasets/checked_table.h"

namespace gaitcam {

enum class ImageKind { kPicture, kDepth, kVectors };

struct CheckedImage {
  int64_t stamp_ns = 0;
  int line = 0;
  std::filesystem::path file;
  uint64_t content = 0;  ///< Hash of its pixels; 0 if it could not be read.
};

/// Reads NAME.txt (TUM: rows "t NAME/file") or NAME/data.csv (EuRoC: rows "t,file" in NAME/data) and every image:
/// there, whole, of its kind and the calibrated size, not of one colour, named by its time; and no file that is not
/// listed.
/// @param by_ours also what only recordings of ours promise.
std::vector<CheckedImage> CheckImages(const std::filesystem::path& root, const std::string& name, bool tum,
                                      ImageKind kind, const CameraModel& camera, bool by_ours, Problems& problems);

/// What is wrong with an image file, or nothing.
std::string FaultOfImage(const std::filesystem::path& file, ImageKind kind, const CameraModel& camera,
                         uint64_t* content);

}  // namespace gaitcam
