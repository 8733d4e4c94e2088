/// Discarding features of low entropy (thesis, section 5.3.2, equation 5.18).

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/features/features.h"

namespace gaitcam {

/// Shannon entropy, in nats, of each descriptor taken as a probability mass function (its entries are divided by their
/// sum).
/// @param descriptors CV_32FC1, entries >= 0.
/// @returns one value per row; 0 for a row of zeros.
std::vector<double> DescriptorEntropies(const cv::Mat& descriptors);

/// Removes the features whose entropy is less than mean - standard deviation of all of them.
Features DiscardLowEntropy(const Features& features);

}  // namespace gaitcam
