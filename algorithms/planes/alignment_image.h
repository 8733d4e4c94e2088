/// The image that direct alignment compares: linear light, smoothed.
///
/// An exposure integrates light, and the camera's response follows it: a blurred image is the mean of sharp ones in
/// linear light only. At an edge between black and white, averaging display values instead displaces the blurred edge
/// by a good part of its width. Smoothing by 1 px makes bilinear interpolation and central differences accurate enough,
/// and reduces the noise.

#pragma once

#include <opencv2/core.hpp>

namespace gaitcam {

/// @param image CV_8UC1 or CV_8UC3, display values (sRGB).
/// @return CV_32FC1, linear light from 0 to 255, smoothed by a Gaussian of 1 px.
cv::Mat AlignmentImage(const cv::Mat& image);

}  // namespace gaitcam
