/// Correspondences between the features of two images by their descriptors alone (thesis 3.5.3).

#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// Which pairs match (thesis 3.5.3).
enum class MatchStrategy {
  kThreshold,     ///< All that are near enough; a row may have many.
  kNearest,       ///< The nearest.
  kNearestRatio,  ///< The nearest, if much nearer than the second.
};
constexpr auto WordsOf(MatchStrategy) {
  return std::array{EnumWord{MatchStrategy::kThreshold, "threshold"}, EnumWord{MatchStrategy::kNearest, "nn"},
                    EnumWord{MatchStrategy::kNearestRatio, "nndr"}};
}

/// How the nearest descriptor is found.
enum class NeighbourSearch { kExact, kBestBinFirst };
constexpr auto WordsOf(NeighbourSearch) {
  return std::array{EnumWord{NeighbourSearch::kExact, "exact"}, EnumWord{NeighbourSearch::kBestBinFirst, "bbf"}};
}

struct MatchingOptions {
  using DescribedTag = void;

  double ratio = 0.8;  ///< nndr: nearest over second nearest distance must be below this (Lowe 2004, section 7.1); 1:
                       ///< no test.
  bool mutual = true;  ///< Keep only pairs that are each other's nearest. Not for `threshold`.
  MatchStrategy strategy = MatchStrategy::kNearestRatio;
  double max_distance = 0;  ///< Largest distance of a match; 0: any (not for `threshold`). Euclidean, or bits.
  NeighbourSearch search = NeighbourSearch::kExact;
  int max_candidates = 200;  ///< bbf: descriptors compared per query (Beis and Lowe's E_max); 0: until exact.
};

template <class Visitor>
void VisitFields(Visitor& visit, MatchingOptions& o) {
  visit("ratio", o.ratio, Between(0.1, 1.0), "ratio test: nearest over second nearest distance");
  visit("mutual", o.mutual, Nested(), "keep pairs that are each other's nearest");
  visit("strategy", o.strategy, EnumWords<MatchStrategy>(), "which pairs match");
  visit("max_distance", o.max_distance, AtLeast(0), "largest distance of a match; 0: any");
  visit("search", o.search, EnumWords<NeighbourSearch>(), "how the nearest is found: all compared, or best bin first");
  visit("max_candidates", o.max_candidates, AtLeast(0), "bbf: descriptors compared per query; 0: until exact");
}

struct Match {
  int a = -1, b = -1;  ///< Rows of the two descriptor matrices.
  float distance = 0;  ///< Of the descriptors: Euclidean (CV_32F), or number of bits that differ (CV_8U).
};

/// Pairs each row of `a` with its nearest row of `b`, in the order of `a`; no row of `b` is used twice if `mutual`.
/// Of equally near rows the first. Strategy `threshold`: all pairs below max_distance, in the order of `a`, then `b`.
/// @param a, b CV_32FC1 or CV_8UC1, one descriptor per row, the same type and number of columns; either may be empty.
/// @throws BadOption for strategy threshold without a max_distance.
std::vector<Match> MatchDescriptors(const cv::Mat& a, const cv::Mat& b, const MatchingOptions& options);

}  // namespace gaitcam
