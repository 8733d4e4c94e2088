/// Whether a blur averaged light or grey values. A camera's exposure integrates light, and its response curve is
/// applied afterwards; a filtered image, or a camera with a linear response, has its grey values averaged. Restoration
/// must act on the same quantity.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// Exponent of the response that is assumed: grey = light^(1 / kResponseGamma).
constexpr double kResponseGamma = 2.2;

/// Light from 0 to 1 of grey values, CV_8UC1 to CV_32FC1.
cv::Mat LightOfGrey(const cv::Mat& grey);

/// Grey values, 1 being white, of light: CV_32FC1. Negative light gives 0; light above 1 gives values above 1.
cv::Mat GreyOfLight(const cv::Mat& light);

/// True if the blur acted on light. Where a line's transfer function has its first zero, the spectrum of what was
/// averaged has a minimum, which a response curve fills: the quantity with the deeper minimum is returned.
/// @param grey CV_8UC1; its middle, at most 400 pixels square, is evaluated.
bool BlurActedOnLight(const cv::Mat& grey, const LineBlur& blur);

}  // namespace gaitcam
