/// What textures are painted with: tinting of a brightness field, and marks of use that wrap around.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/random.h"

namespace gaitcam {

/// Colour `rgb` (0..1) times the brightness `factor` (CV_32FC1), saturated. @returns CV_8UC3, BGR.
cv::Mat Tint(const cv::Mat& factor, const Eigen::Vector3d& rgb);

/// As above for one colour. @returns BGR, 0..255.
cv::Scalar Bgr(const Eigen::Vector3d& rgb);

/// A filled disc with soft edges, cut off at the picture's edges. For CV_8UC3; (0, 0) is the centre of the first pixel.
void FillDisc(cv::Mat& bgr, cv::Point2d center, double radius, const cv::Scalar& color);

/// Lines of made-up words in `area`, letters `letter_px` tall.
void DrawWords(cv::Mat& bgr, const cv::Rect& area, double letter_px, const cv::Scalar& color, RandomStream& random);

/// A random colour whose brightness lies between `low` and `high`. @returns BGR, 0..255.
cv::Scalar RandomColor(RandomStream& random, double low, double high);

/// Spots and scratches, collected in one layer that wraps around, then multiplied into a picture.
class Wear {
 public:
  explicit Wear(cv::Size size);
  /// Round spots; strength is the greatest change of brightness (part), half of the spots lighter.
  void AddSpots(int count, double min_radius_px, double max_radius_px, double strength, RandomStream& random);
  /// Bent hairlines of about one pixel's width.
  void AddScratches(int count, double min_length_px, double max_length_px, double strength, RandomStream& random);
  /// Dark cracks that wander and branch.
  void AddCracks(int count, double length_px, double strength, RandomStream& random);
  void ApplyTo(cv::Mat& bgr) const;

 private:
  void DrawPath(const std::vector<cv::Point2d>& points, double level);
  cv::Mat layer_;  ///< CV_8UC1, brightness factor times 128.
};

}  // namespace gaitcam
