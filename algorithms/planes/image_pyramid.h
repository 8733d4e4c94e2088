/// Image pyramid with gradients, as direct alignment samples it.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/intrin.hpp>
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
  ImageSample At(const Eigen::Vector2d& p) const { return SampleOf(LanesAt(p)); }

  /// The same as lanes to be added up: intensity, gradients, and a fourth one that means nothing. @pre Contains(p)
  cv::v_float32x4 LanesAt(const Eigen::Vector2d& p) const {
    using cv::v_load;
    const int u = int(p.x()), v = int(p.y());
    const float *const top = samples.ptr<float>(v) + 3 * u, *const bottom = samples.ptr<float>(v + 1) + 3 * u;
    const cv::v_float32x4 one = cv::v_setall_f32(1);
    const cv::v_float32x4 a = cv::v_setall_f32(float(p.x() - u)), b = cv::v_setall_f32(float(p.y() - v));
    return (one - b) * ((one - a) * v_load(top) + a * v_load(top + 3)) +
           b * ((one - a) * v_load(bottom) + a * v_load(bottom + 3));
  }
  static ImageSample SampleOf(const cv::v_float32x4& lanes) {
    alignas(16) float values[4];
    cv::v_store_aligned(values, lanes);
    return {values[0], values[1], values[2]};
  }
};

/// Level 0 is the image; pixel (u, v) of level k lies at (2^k u, 2^k v) of level 0.
struct ImagePyramid {
  std::vector<PyramidLevel> levels;

  /// @param image CV_8UC1 or CV_8UC3. @param levels at least 1; fewer where a side would fall below 16 px.
  static ImagePyramid Of(const cv::Mat& image, int levels);
};

}  // namespace gaitcam
