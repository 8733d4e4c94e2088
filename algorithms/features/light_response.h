/// Whether a blur added up light or grey values. A camera's exposure adds up light, and its response curve comes after;
/// a filtered picture, or a camera with a straight response, has grey values added up. Restoring needs to know.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// Exponent of the response that a camera is taken to have: grey = light^(1 / kResponseGamma).
constexpr double kResponseGamma = 2.2;

/// Light from 0 to 1 of grey values, CV_8UC1 to CV_32FC1.
cv::Mat LightOfGrey(const cv::Mat& grey);

/// Grey values, 1 being white, of light: CV_32FC1. Negative light gives 0; light above 1 gives values above 1.
cv::Mat GreyOfLight(const cv::Mat& light);

/// True if the blur acted on light. Where a line's transfer function has its first zero, the spectrum of what was added
/// up has a trough; a response curve fills it. So of the two, the one with the deeper trough.
/// @param grey CV_8UC1; its middle, at most 400 pixels square, is looked at.
bool BlurActedOnLight(const cv::Mat& grey, const LineBlur& blur);

}  // namespace gaitcam
