/// Distances of one descriptor from some of many.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// Euclidean distances of CV_32FC1 descriptors, Hamming distances of CV_8UC1.
/// @param query one row.
/// @param rows one descriptor per row, the query's type and length.
/// @param chosen rows to compare with.
/// @param distances of each of `chosen`, in their order; what it held is lost.
void DescriptorDistances(const cv::Mat& query, const cv::Mat& rows, const std::vector<int>& chosen,
                         std::vector<float>& distances);

}  // namespace gaitcam
