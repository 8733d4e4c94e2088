#include "algorithms/features/pirf.h"

#include <string>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

std::string SizeText(const cv::Size& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height) + " px";
}

void CheckSizes(std::span<const FeatureImage> images) {
  for (size_t i = 1; i < images.size(); ++i) {
    const cv::Size &first = images[0].size_px, &size = images[i].size_px;
    if (size != first)
      throw BadInput("image " + std::to_string(i) + " of a window: " + SizeText(size) + "; expected " +
                     SizeText(first) + " as the first");
  }
}

cv::Mat Representatives(std::span<const FeatureImage> window, const std::vector<std::vector<int>>& chains) {
  const cv::Mat& last = window.back().features.descriptors;
  cv::Mat descriptors(int(chains.size()), last.cols, last.type(), cv::Scalar(0));
  for (size_t c = 0; c < chains.size(); ++c) {
    cv::Mat row = descriptors.row(int(c));
    if (last.type() == CV_8UC1) {
      last.row(chains[c].back()).copyTo(row);
      continue;
    }
    for (size_t i = 0; i < window.size(); ++i) row += window[i].features.descriptors.row(chains[c][i]);
    row /= double(window.size());
  }
  return descriptors;
}

}  // namespace

std::vector<std::vector<int>> ChainFeatures(std::span<const FeatureImage> images, const MatchingOptions& matching,
                                            const MatchFilter& filter) {
  CheckSizes(images);
  std::vector<std::vector<int>> chains;
  for (int i = 0; !images.empty() && i < images[0].features.size(); ++i) chains.push_back({i});
  for (size_t k = 1; k < images.size(); ++k) {
    const Features &a = images[k - 1].features, &b = images[k].features;
    std::vector<Match> matches = MatchDescriptors(a.descriptors, b.descriptors, matching);
    if (filter) matches = filter(matches, a, b);
    std::vector<int> next(size_t(a.size()), -1);
    for (const Match& match : matches) next[size_t(match.a)] = match.b;
    std::vector<std::vector<int>> longer;
    for (std::vector<int>& chain : chains) {
      const int row = next[size_t(chain.back())];
      if (row < 0) continue;
      chain.push_back(row);
      longer.push_back(std::move(chain));
    }
    chains = std::move(longer);
  }
  return chains;
}

std::vector<PirfSet> ExtractPirf(std::span<const FeatureImage> images, const PirfOptions& options) {
  CheckFields(options, "pirf.");
  std::vector<PirfSet> sets;
  const auto window = size_t(options.window);
  for (size_t begin = 0; begin + window <= images.size(); ++begin) {
    const auto part = images.subspan(begin, window);
    PirfSet set;
    set.rows = ChainFeatures(part, options.matching);
    set.descriptors = Representatives(part, set.rows);
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace gaitcam
