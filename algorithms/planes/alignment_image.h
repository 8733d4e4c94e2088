/// The picture that direct alignment compares: light, a little smoothed.
///
/// An exposure adds up light, and the camera's response comes after it: a blurred picture is a mean of sharp ones in
/// light alone. At an edge between black and white, taking display values for light misplaces the blurred edge by a
/// good part of its width. Smoothing by one pixel makes the picture smooth enough for what alignment does to it,
/// interpolation between four pixels and differences for gradients, and takes off most of the noise.

#pragma once

#include <opencv2/core.hpp>

namespace gaitcam {

/// @param image CV_8UC1 or CV_8UC3, display values (sRGB).
/// @return CV_32FC1, linear light from 0 to 255, smoothed by a Gaussian of 1 px.
cv::Mat AlignmentImage(const cv::Mat& image);

}  // namespace gaitcam
