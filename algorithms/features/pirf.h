/// Position-Invariant Robust Features: those that are found again in each of several images in a row.
///
/// Source: Kawewong, Tangruamsup and Hasegawa, as told by Hua, section 3.3 and figure 3.17.

#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"

namespace gaitcam {

/// What was found in an image.
struct FeatureImage {
  cv::Size size_px;
  Features features;
};

/// Which matches between two images are to be believed; handed over with the images' features, in their order.
using MatchFilter =
    std::function<std::vector<Match>(const std::vector<Match>& matches, const Features& a, const Features& b)>;

/// Features of the first image that are found again in the second, from there in the third, and so on.
/// @returns for each of them its rows in all images. Every feature of a single image.
/// @param filter of the matches between two neighbours; null keeps all.
/// @throws BadInput if the images differ in size.
std::vector<std::vector<int>> ChainFeatures(std::span<const FeatureImage> images, const MatchingOptions& matching,
                                            const MatchFilter& filter = nullptr);

struct PirfOptions {
  using DescribedTag = void;
  int window = 3;
  MatchingOptions matching;
};

template <class Visitor>
void VisitFields(Visitor& visit, PirfOptions& o) {
  visit("window", o.window, AtLeast(2), "images in a row that a feature is found in");
  visit("matching", o.matching, Nested(), "between neighbours");
}

/// Features of one window.
struct PirfSet {
  std::vector<std::vector<int>> rows;  ///< Of each its rows in the window's images, oldest first.
  cv::Mat descriptors;                 ///< The mean over the images; of binary ones, that of the last image.
};

/// One set per window of neighbours: images 0 ... window - 1, then 1 ... window, and so on.
/// @returns none if there are fewer images than a window has.
/// @throws BadInput if the images differ in size; BadOption.
std::vector<PirfSet> ExtractPirf(std::span<const FeatureImage> images, const PirfOptions& options);

}  // namespace gaitcam
