/// Validation of a table of images and of the images it lists.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "scenarios/code/datasets/checked_table.h"

namespace gaitcam {

enum class ImageKind { kPicture, kDepth, kVectors };

struct CheckedImage {
  int64_t stamp_ns = 0;
  int line = 0;
  std::filesystem::path file;
  uint64_t content = 0;  ///< Hash of its pixels; 0 if it could not be read.
};

/// Reads NAME.txt (TUM: rows "t NAME/file") or NAME/data.csv (EuRoC: rows "t,file" in NAME/data) and every image:
/// present, complete, of the right type and the calibrated size, not of one colour, named by its time; and that no file
/// is unlisted.
/// @param by_ours also checks what only gaitcam's own recordings guarantee.
std::vector<CheckedImage> CheckImages(const std::filesystem::path& root, const std::string& name, bool tum,
                                      ImageKind kind, const CameraModel& camera, bool by_ours, Problems& problems);

/// The fault of an image file; nothing if it is sound.
std::string FaultOfImage(const std::filesystem::path& file, ImageKind kind, const CameraModel& camera,
                         uint64_t* content);

}  // namespace gaitcam
