/// Photographs blurred along a line, as a camera that moves evenly would, and as one that a walk shakes: input with
/// known truth for tests and experiments.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// Points of a line, 20 to a pixel, each shared between the four pixels around it; centred, sums to 1. CV_32FC1, odd
/// sides.
cv::Mat LineBlurKernel(const LineBlur& blur);

/// Blurs, then crops what the border has touched (and to at most `size` px), then adds noise and rounds.
/// @param grey CV_8UC1. @param noise standard deviation, grey values.
/// @param linear_light light is added before the display's gamma of 2.2, as in a camera, instead of after it.
/// @returns CV_8UC1.
cv::Mat BlurPhotograph(const cv::Mat& grey, const LineBlur& blur, double noise, uint64_t seed,
                       bool linear_light = false, cv::Size size = {640, 480});

/// How the image moves during an exposure.
enum class BlurKind {
  kLine,      ///< Straight and even.
  kRamp,      ///< Straight; the speed grows or falls fivefold, from 1/3 to 5/3 of its mean.
  kArc,       ///< Even along a quarter of a circle.
  kJitter,    ///< A straight and even motion with two sines of 1 to 4 cycles on it, along and across, 1.5 px at most.
  kRotation,  ///< Even, about the middle of the image.
};
constexpr auto WordsOf(BlurKind) {
  return std::array{EnumWord{BlurKind::kLine, "line"}, EnumWord{BlurKind::kRamp, "ramp"},
                    EnumWord{BlurKind::kArc, "arc"}, EnumWord{BlurKind::kJitter, "jitter"},
                    EnumWord{BlurKind::kRotation, "rotation"}};
}

/// A motion of the image in its plane: what lies at p without blur lies at c + R(turn) (p - c) + shift.
struct ImageMotion {
  std::vector<Eigen::Vector2d> shifts;               ///< px, at equal steps of time from shutter open to close; mean 0.
  std::vector<double> turns_rad;                     ///< At the same times; positive from x to y.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< c, px.

  /// Where the light of a pixel went.
  BlurPath PathAt(const Eigen::Vector2d& pixel) const;
  /// The same motion in an image whose first pixel was at `corner`.
  ImageMotion Cropped(const Eigen::Vector2d& corner) const;
};

/// @param extent_px length of the path, jitter aside; of a rotation, at the median over the image's pixels.
/// @param seed of directions, signs and phases.
ImageMotion DrawMotion(BlurKind kind, double extent_px, const cv::Size& image, uint64_t seed);

/// The mean of the images that it moves through; beyond the border the image is mirrored.
/// @param image CV_32FC1, in the units that the blur acts on. @returns the same size.
cv::Mat BlurAlong(const cv::Mat& image, const ImageMotion& motion);

/// The lesser of the distances to a blur vector and to its opposite, which is the same blur, px.
double BlurVectorError(const Eigen::Vector2d& a, const cv::Vec2f& b);

}  // namespace gaitcam
