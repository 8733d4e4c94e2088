/// Vocabularies and places made up for tests: words whose descriptors are unmistakable.

#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "algorithms/features/features.h"
#include "algorithms/places/visual_words.h"

namespace gaitcam {

/// Unit vectors, any two of them about sqrt(2) apart.
inline cv::Mat UnitRows(int rows, int columns, uint64_t seed) {
  RandomStream random(seed, "unit_rows");
  cv::Mat unit(rows, columns, CV_32FC1);
  for (int row = 0; row < rows; ++row) {
    for (int d = 0; d < columns; ++d) unit.at<float>(row, d) = float(random.Normal());
    unit.row(row) /= cv::norm(unit.row(row));
  }
  return unit;
}

/// Features whose descriptors are these rows of `all`, each disturbed by `noise` in length; keypoints are spread over
/// an image in the order of `rows`.
inline Features SeenRows(const cv::Mat& all, const std::vector<int>& rows, double noise, RandomStream& random) {
  Features seen;
  for (const int row : rows) {
    cv::Mat descriptor = all.row(row).clone();
    for (float& value : cv::Mat_<float>(descriptor)) value += float(random.Normal(0, noise / std::sqrt(all.cols)));
    seen.descriptors.push_back(descriptor);
    seen.keypoints.emplace_back(cv::Point2f(float(37 * row % 320), float(91 * row % 240)), 10.0f);
  }
  return seen;
}

/// `count` different numbers below `limit`, sorted.
inline WordSet Draw(int count, int limit, RandomStream& random) {
  WordSet all(size_t(limit), 0);
  for (int k = 0; k < limit; ++k) all[size_t(k)] = k;
  for (int k = 0; k < count; ++k) std::swap(all[size_t(k)], all[size_t(k + random.Index(limit - k))]);
  all.resize(size_t(count));
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace gaitcam
