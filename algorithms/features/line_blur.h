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

/// Any motion of a point's image during the exposure, as an exposure of a walk has it: bent, and faster here than
/// there.
struct BlurPath {
  /// Where the light of a pixel went, px from that pixel, at equal steps of time from shutter open to close; straight
  /// and even in between. Fewer than two: no motion.
  std::vector<Eigen::Vector2d> points;

  bool empty() const { return points.size() < 2; }
  /// The way along it, px.
  double Length() const {
    double length = 0;
    for (size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
    return length;
  }
  /// The line blur of its ends.
  LineBlur Chord() const { return empty() ? LineBlur{} : LineBlur::FromVector(points.back() - points.front()); }
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
  BlurPath path = {};  ///< Where it is known: instead of the line `estimate.blur`, which then only summarises it.
};

}  // namespace gaitcam
