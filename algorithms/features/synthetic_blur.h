/// Photographs blurred along a line, as a camera that moves evenly would: input with known truth for tests and
/// experiments.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

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

/// The lesser of the distances to a blur vector and to its opposite, which is the same blur, px.
double BlurVectorError(const Eigen::Vector2d& a, const cv::Vec2f& b);

}  // namespace gaitcam
