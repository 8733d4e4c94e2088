#include "algorithms/odometry/feature_search.h"

#include "algorithms/features/descriptor_distance.h"

namespace gaitcam {

NearestFeature DescriptorSearch::Find(const cv::Mat& descriptor, const cv::Mat& latest,
                                      const std::vector<int>& candidates) {
  if (candidates.empty()) return {};
  DescriptorDistances(descriptor, descriptors_, candidates, distances_);
  if (!latest.empty()) {
    DescriptorDistances(latest, descriptors_, candidates, of_latest_);
    for (size_t k = 0; k < candidates.size(); ++k) distances_[k] = std::min(distances_[k], of_latest_[k]);
  }
  NearestFeature best;
  for (size_t k = 0; k < candidates.size(); ++k) {
    if (double(distances_[k]) < best.distance) best = {candidates[k], double(distances_[k])};
  }
  for (size_t k = 0; k < candidates.size(); ++k) {
    if (double(distances_[k]) * ratio_ > best.distance || candidates[k] == best.feature) continue;
    const Eigen::Vector2d apart = xy_[size_t(candidates[k])] - xy_[size_t(best.feature)];
    if (apart.norm() > same_point_) return {};
  }
  return best;
}

}  // namespace gaitcam
