/// Division of an image into parts with a blur of their own: the modified K-means clustering of the thesis (section
/// 5.3.1, equation 5.17).
///
/// blur_field.h is an alternative that models rotation about the optical axis.

#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_blur.h"
#include "algorithms/features/psf_whitening.h"

namespace gaitcam {

struct BlurSegmentationOptions {
  using DescribedTag = void;
  int clusters = 2;                 ///< K; 2 is enough, by the thesis.
  int directions = 18;              ///< Bins of the histogram of each sample point.
  int sample_step_px = 10;          ///< Between sample points.
  int max_iterations = 30;          ///< Stops there if the labels still change.
  double merge_direction_deg = 10;  ///< Clusters whose directions
  double merge_extent_px = 3;       ///< and extents differ by less than this become one; 0 never merges.
  WhiteningOptions extent;          ///< How a cluster's extent is measured.
};

template <class Visitor>
void VisitFields(Visitor& visit, BlurSegmentationOptions& o) {
  visit("clusters", o.clusters, Between(1, 16), "number of clusters, K");
  visit("directions", o.directions, Between(4, 180), "bins of a sample point's histogram over 180 degrees");
  visit("sample_step_px", o.sample_step_px, Between(2, 100), "between sample points");
  visit("max_iterations", o.max_iterations, Between(1, 1000), "limit of the clustering");
  visit("merge_direction_deg", o.merge_direction_deg, Between(0, 90), "clusters nearer than this");
  visit("merge_extent_px", o.merge_extent_px, Between(0, 100), "and this become one");
  visit("extent", o.extent, Nested(), "how a cluster's extent is measured");
}

/// @param grey CV_8UC1.
/// @returns regions that cover the image without overlap, in reading order; one region if there is one blur.
/// @throws BadOption
std::vector<BlurRegion> SegmentBlur(const cv::Mat& grey, const BlurSegmentationOptions& options = {});

/// The label of each sample point of the grid, CV_8UC1, and the clusters' blurs: what SegmentBlur goes by.
struct BlurClusters {
  cv::Mat labels;
  std::vector<BlurEstimate> estimates;
  std::vector<cv::Point2d> centroids;  ///< px.
};
BlurClusters ClusterBlur(const cv::Mat& grey, const BlurSegmentationOptions& options = {});

}  // namespace gaitcam
