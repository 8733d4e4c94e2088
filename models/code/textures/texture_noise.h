/// Random fields that textures are made of. All wrap around at their edges, have zero mean and unit variance, and are
/// CV_32FC1.

#pragma once

#include <cmath>
#include <opencv2/core.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {

/// Independent uniform values per pixel.
cv::Mat WhiteNoise(cv::Size size, RandomStream& random);

/// Repeats the field's grid `across` times finer in x and `down` times in y, smoothly (bicubic); not normalised.
cv::Mat Enlarge(const cv::Mat& field, int across, int down);

/// A sum of octaves with grain from `coarsest_px` down to `finest_px` (powers of two that divide the size). Each octave
/// has `roughness` times the amplitude of the next coarser one: 1 gives the 1/f amplitude spectrum of natural images
/// (Field, "Relations between the statistics of natural images and the response properties of cortical cells", 1987).
cv::Mat FractalNoise(cv::Size size, int coarsest_px, int finest_px, double roughness, RandomStream& random);

/// Streaks along x of about `length_px` (divides the width), one pixel wide, with coarser streaks mixed in: wood grain.
cv::Mat StreakNoise(cv::Size size, int length_px, RandomStream& random);

/// Growth rings of wood across a phase of one per ring: slowly darker, then quickly light again. @returns -1..0.5.
inline float GrowthRing(float phase) {
  constexpr float kEdge = 0.82f;  // not a jump: that would show as stairs in close-ups
  const float part = phase - std::floor(phase);
  const float rise = part < kEdge ? part / kEdge : (1 - part) / (1 - kEdge);
  return 0.5f - 1.5f * rise * rise;
}

/// Subtracts the mean and divides by the standard deviation.
void Normalize(cv::Mat& field);

/// Least multiple of `step` that is not below `value`.
inline int RoundUp(int value, int step) { return (value + step - 1) / step * step; }

/// Value of `x` wrapped into [0, period).
inline int Wrap(int x, int period) {
  x %= period;
  return x < 0 ? x + period : x;
}

}  // namespace gaitcam
