#include "algorithms/odometry/landmark_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "algorithms/features/matching.h"
#include "algorithms/geometry/inverse_depth.h"
#include "algorithms/odometry/feature_search.h"

namespace gaitcam {
std::vector<LandmarkMatch> SearchNear(const KeyframeMap& map, const FrameView& view, const Pose& X_WC,
                                      const LandmarkSearchOptions& options) {
  const FeatureGrid grid(view.xy, std::max(0.02, options.radius));
  std::vector<LandmarkClaim> claims(view.xy.size());
  DescriptorSearch search(view.xy, view.features.descriptors, options.ratio, options.same_point);
  const InverseDepthCamera camera(X_WC);
  std::vector<Eigen::Matrix3d> R_WA;
  for (const Pose& X_WA : map.keyframes()) R_WA.push_back(X_WA.R());
  std::vector<int> candidates;
  for (size_t l = 0; l < map.landmarks().size(); ++l) {
    const Landmark& landmark = map.landmarks()[l];
    const size_t anchor = size_t(landmark.anchor);
    const auto projection = camera.See({R_WA[anchor], map.keyframes()[anchor].translation, landmark.ray, landmark.rho});
    if (!projection) continue;
    const double spread = options.depth_sigmas * landmark.rho_sigma * projection->d_rho.norm();
    const double radius = options.radius + std::min(spread, 2 * options.radius);
    candidates.clear();
    grid.Near(projection->xy, std::max(radius, options.rivals), [&](int i) { candidates.push_back(i); });
    const NearestFeature found = search.Find(landmark.descriptor, landmark.latest, candidates);
    if (found.feature < 0 || (view.xy[size_t(found.feature)] - projection->xy).norm() > radius) continue;
    const LandmarkClaim claim = {int(l), landmark.observations.size(), found.distance};
    LandmarkClaim& present = claims[size_t(found.feature)];
    if (present.landmark < 0 || claim.Beats(present)) present = claim;
  }
  std::vector<LandmarkMatch> matches;
  for (size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].landmark >= 0) matches.push_back({claims[i].landmark, int(i)});
  }
  return matches;
}

std::vector<LandmarkMatch> SearchAnywhere(const KeyframeMap& map, const FrameView& view, double ratio) {
  if (map.landmarks().empty() || view.xy.empty()) return {};
  cv::Mat descriptors;
  for (const Landmark& landmark : map.landmarks()) descriptors.push_back(landmark.descriptor);
  MatchingOptions matching;
  matching.ratio = ratio;
  std::vector<LandmarkMatch> matches;
  for (const Match& match : MatchDescriptors(descriptors, view.features.descriptors, matching)) {
    matches.push_back({match.a, match.b});
  }
  return matches;
}

}  // namespace gaitcam
