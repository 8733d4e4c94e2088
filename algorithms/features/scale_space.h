/// Gaussian scale space of an image (thesis, section 5.2.3, equation 5.7).
///
/// Each octave has half the resolution of the one before it. Within an octave the scale grows by 2^(1/intervals).

#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// One smoothed image of an octave.
struct ScaleLevel {
  double sigma = 0;  ///< Scale in the octave's own pixels.
  cv::Mat light;     ///< CV_32FC1.
};

struct ScaleOctave {
  double pitch_px = 1;             ///< Distance of two of its pixels, in pixels of the image.
  double origin_px = 0;            ///< Where the centre of its first pixel lies in the image, both coordinates.
  std::vector<ScaleLevel> levels;  ///< intervals + 2, finest first.
};

using ScaleSpace = std::vector<ScaleOctave>;

struct ScaleSpaceOptions {
  using DescribedTag = void;
  double sigma = 1.6;          ///< Scale of each octave's finest level, in its own pixels.
  int intervals = 3;           ///< s: levels per doubling of the scale.
  int octaves = 4;             ///< At most; octaves stop where the image gets too small.
  double camera_sigma = 0.5;   ///< Blur that the image is taken to have already, px.
  bool first_doubled = false;  ///< Put an octave of twice the image's resolution first.
};

template <class Visitor>
void VisitFields(Visitor& visit, ScaleSpaceOptions& o) {
  visit("sigma", o.sigma, Between(0.7, 8), "scale of each octave's finest level, in its own pixels");
  visit("intervals", o.intervals, Between(1, 10), "levels per octave");
  visit("octaves", o.octaves, Between(1, 12), "at most");
  visit("camera_sigma", o.camera_sigma, Between(0, 2), "blur that the image is taken to have, px");
  visit("first_doubled", o.first_doubled, Nested(), "put an octave of twice the image's resolution first");
}

/// An octave smaller than this on either side is not made.
constexpr int kMinOctavePx = 24;

/// Scales of an octave's levels: sigma * 2^(i / intervals) for i = 0 ... intervals + 1 (5.2.3: 1.6, 2.0159, 2.5398,
/// 3.2, 4.0317).
std::vector<double> LevelScales(const ScaleSpaceOptions& options);

/// Equation 5.7 by repeated smoothing; the level of twice the first scale, every second pixel of it, begins the next
/// octave.
/// @param image CV_32FC1.
/// @returns no octave at all for an image that is too small.
ScaleSpace BuildScaleSpace(const cv::Mat& image, const ScaleSpaceOptions& options);

}  // namespace gaitcam
