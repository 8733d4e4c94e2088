#include "scenarios/code/experiments/photographs.h"

#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {

std::filesystem::path PackagedPicture(const std::string& name) {
  const std::filesystem::path file = "/usr/share/doc/opencv-doc/examples/data/" + name;
  if (!std::filesystem::exists(file))
    throw MissingResource(file.string() + ": missing; install Debian's package opencv-doc");
  return file;
}

cv::Mat PackagedPhotograph(const std::string& name) {
  const cv::Mat grey = cv::imread(PackagedPicture(name).string(), cv::IMREAD_GRAYSCALE);
  if (grey.empty()) throw MissingResource(PackagedPicture(name).string() + ": cannot be read as an image");
  return grey;
}

}  // namespace gaitcam
