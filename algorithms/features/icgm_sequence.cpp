#include "algorithms/features/icgm_sequence.h"

#include <algorithm>
#include <set>

#include "algorithms/core/errors.h"

namespace gaitcam {

std::vector<int> RobustFeatures(std::span<const FeatureImage> images, int current, const RobustFeatureOptions& options,
                                RandomStream& random) {
  GAITCAM_ASSERT(current >= 0 && current < int(images.size()));
  CheckFields(options, "robust_features.");
  const MatchFilter filter = [&](const std::vector<Match>& matches, const Features& a, const Features& b) {
    return FilterByGravity(matches, a, b, options.icgm, random);
  };
  const int before = current - options.window + 1, after = current + options.window;
  std::set<int> rows;
  if (before >= 0) {
    for (const std::vector<int>& chain :
         ChainFeatures(images.subspan(size_t(before), size_t(options.window)), options.matching, filter))
      rows.insert(chain.back());
  }
  if (options.direction == IcgmDirection::kDouble && after <= int(images.size())) {
    for (const std::vector<int>& chain :
         ChainFeatures(images.subspan(size_t(current), size_t(options.window)), options.matching, filter))
      rows.insert(chain.front());
  }
  return {rows.begin(), rows.end()};
}

double TurningShare(double lambda, IcgmDirection direction) {
  GAITCAM_ASSERT(lambda >= 0);
  const double single = std::max(0.0, 1 - lambda);
  return direction == IcgmDirection::kSingle ? single : std::min(1.0, 2 * single);
}

double RecedingShare(double lambda, IcgmDirection direction) {
  GAITCAM_ASSERT(lambda >= 0 && lambda <= 1);
  return direction == IcgmDirection::kSingle ? (1 - lambda) * (1 - lambda) : 1;
}

}  // namespace gaitcam
