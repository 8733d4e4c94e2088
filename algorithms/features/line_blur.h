/// Motion blur of one image or of a part of it, as a straight and uniform motion during the exposure (thesis, section
/// 5.2, equation 5.2).

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// Light of each point spread evenly over a segment centred on it. Directions d and d + pi are the same blur.
struct LineBlur {
  double extent_px = 0;      ///< Length of the segment; 0 is a sharp image.
  double direction_rad = 0;  ///< In [0, pi): of (cos, sin) with x to the right and y DOWN.

  /// From one end of the segment to the other, px.
  Eigen::Vector2d Vector() const {
    return extent_px * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
  }
  static LineBlur FromVector(const Eigen::Vector2d& v) {
    double direction = std::atan2(v.y(), v.x());
    if (direction < 0) direction += M_PI;
    if (direction >= M_PI) direction -= M_PI;
    return {v.norm(), direction};
  }
  /// Angle between two blurs' directions, in [0, pi/2].
  double DirectionError(const LineBlur& other) const {
    const double d = std::fmod(std::abs(direction_rad - other.direction_rad), M_PI);
    return std::min(d, M_PI - d);
  }
};

/// Result of an estimator of the point spread function.
struct BlurEstimate {
  LineBlur blur;          ///< Best estimate, also where `blurred` is false.
  double confidence = 0;  ///< From 0 to 1; each estimator's header defines it.
  bool blurred = false;   ///< False: the image is to be left unchanged.
};

/// A part of an image with blur of its own.
struct BlurRegion {
  cv::Rect rectangle;
  BlurEstimate estimate;
};

}  // namespace gaitcam
