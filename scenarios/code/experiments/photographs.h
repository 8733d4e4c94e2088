/// Photographs that come with Debian's opencv-doc.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace gaitcam {

/// Its file. @throws MissingResource naming the package.
std::filesystem::path PackagedPicture(const std::string& name);

/// CV_8UC1. @throws MissingResource naming the package.
cv::Mat PackagedPhotograph(const std::string& name);

}  // namespace gaitcam
