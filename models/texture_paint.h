/// What textures are painted with: tinting of a brightness field, and marks of use that wrap around.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {

/// Colour `rgb` (0..1) times the brightness `factor` (CV_32FC1), saturated. @returns CV_8UC3, BGR.
cv::Mat Tint(const cv::Mat& factor, const Eigen::Vector3d& rgb);

/// As above for one colour. @returns BGR, 0..255.
cv::Scalar Bgr(const Eigen::Vector3d& rgb);

/// Spots and scratches, collected in one layer that wraps around, then multiplied into a picture.
class Wear {
 public:
  explicit Wear(cv::Size size);
  /// Round spots; strength is the greatest change of brightness (part), half of the spots lighter.
  void AddSpots(int count, double min_radius_px, double max_radius_px, double strength, RandomStream& random);
  /// Bent hairlines of about one pixel's width.
  void AddScratches(int count, double min_length_px, double max_length_px, double strength, RandomStream& random);
  void ApplyTo(cv::Mat& bgr) const;

 private:
  double Level(double strength, RandomStream& random) const;
  cv::Mat layer_;  ///< CV_8UC1, brightness factor times 128.
};

}  // namespace gaitcam
