#include "sim/camera/jpeg.h"

#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {

cv::Mat ThroughJpeg(const cv::Mat& image, const JpegOptions& options) {
  std::vector<uchar> bytes;
  GAITCAM_ASSERT(cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, options.quality}));
  cv::Mat decoded = cv::imdecode(bytes, image.channels() == 1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
  GAITCAM_ASSERT(decoded.size() == image.size() && decoded.type() == image.type());
  return decoded;
}

}  // namespace gaitcam
