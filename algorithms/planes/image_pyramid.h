/// Image pyramid with gradients, as direct alignment samples it.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// Intensity and gradient between pixels.
struct ImageSample {
  float intensity = 0;
  float du = 0, dv = 0;  ///< Per pixel of the level.
};

struct PyramidLevel {
  cv::Mat samples;  ///< CV_32FC3: intensity 0..255, gradient along u and v (central differences).

  int width() const { return samples.cols; }
  int height() const { return samples.rows; }
  /// At least one pixel away from the border, so that all neighbours exist.
  bool Contains(const Eigen::Vector2d& p) const {
    return p.x() >= 1 && p.y() >= 1 && p.x() <= width() - 2.001 && p.y() <= height() - 2.001;
  }
  /// Bilinear. @pre Contains(p)
  ImageSample At(const Eigen::Vector2d& p) const;
};

/// Level 0 is the image; pixel (u, v) of level k lies at (2^k u, 2^k v) of level 0.
struct ImagePyramid {
  std::vector<PyramidLevel> levels;

  /// @param image CV_8UC1 or CV_8UC3. @param levels at least 1; fewer where a side would fall below 16 px.
  static ImagePyramid Of(const cv::Mat& image, int levels);
};

}  // namespace gaitcam
