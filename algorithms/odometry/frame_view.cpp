#include "algorithms/odometry/frame_view.h"

#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {

void CheckImageSize(const cv::Mat& image, const CameraModel& camera) {
  if (image.cols != camera.width_px || image.rows != camera.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera.width_px) + " x " +
                   std::to_string(camera.height_px));
  }
}

FrameView ViewFrame(const cv::Mat& image, const CameraModel& camera, cv::Feature2D& detector, int max_features,
                    const FeatureNoise& noise) {
  CheckImageSize(image, camera);
  FrameView view;
  view.features = DetectFeatures(detector, image, max_features);
  for (const cv::KeyPoint& keypoint : view.features.keypoints) {
    view.xy.push_back(camera.Unproject({keypoint.pt.x, keypoint.pt.y}).head<2>());
    view.sigma.push_back((noise.sigma_px + noise.sigma_per_size * keypoint.size) / camera.fx);
  }
  return view;
}

Words FeatureNames() {
  Words names;
  for (const FeatureInfo& info : ListFeatures()) names.words.push_back(info.name);
  return names;
}

}  // namespace gaitcam
