/// Validation of a table of images and of the images it lists.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/io/dataset_layout.h"
#include "scenarios/code/datasets/checked_table.h"

namespace gaitcam {

enum class ImageKind { kPicture, kDepth, kVectors };

struct CheckedImage {
  int64_t stamp_ns = 0;
  int line = 0;
  std::filesystem::path file;
  uint64_t content = 0;  ///< Hash of its pixels; 0 if it could not be read.
};

/// Reads a table of images and every image: present, complete, of the right type and the calibrated size, not of one
/// colour; and that no file is unlisted.
/// @param by_ours also checks what only gaitcam's own recordings guarantee: three lines of comment before TUM's tables,
/// names that are the images' times and sort by time.
std::vector<CheckedImage> CheckImages(const ImageListing& listing, ImageKind kind, const CameraModel& camera,
                                      bool by_ours, Problems& problems);

/// Faults where the stamps of a table of images differ from those of the frames. What CheckImages tells is not
/// repeated.
/// @param frames stamps of the frames, of the table called `named`.
void CompareImages(const ImageListing& listing, const std::vector<int64_t>& frames, const std::string& named,
                   Problems& problems);

/// A fault unless a table of TUM's layout begins with the three lines of comment that its readers skip.
void CheckTumHeader(CheckedTable& table);

/// The fault of an image file; nothing if it is sound.
std::string FaultOfImage(const std::filesystem::path& file, ImageKind kind, const CameraModel& camera,
                         uint64_t* content);

}  // namespace gaitcam
