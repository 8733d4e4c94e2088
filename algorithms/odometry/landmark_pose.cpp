#include "algorithms/odometry/landmark_pose.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/absolute_pose.h"

namespace gaitcam {
namespace {

double Square(double x) { return x * x; }

/// For a pose that is nearly right.
LandmarkSearchOptions Closely(const LandmarkPoseOptions& options, double noise) {
  LandmarkSearchOptions close = options.search;
  close.radius = noise * options.threshold;
  close.ratio = 0.5 + 0.5 * options.search.ratio;  // nearness has already told most rivals apart
  return close;
}

InverseDepthSighting SightingOf(const LandmarkMap& map, const FrameView& view, const LandmarkMatch& match,
                                double noise) {
  const size_t i = size_t(match.feature);
  return {map.Point(map.landmarks()[size_t(match.landmark)]), view.xy[i], noise * view.sigma[i]};
}

/// The pose that most three-point hypotheses' sightings agree with: of landmarks whose depth is known, as far as there
/// are enough of them.
std::optional<Pose> RoughPose(const LandmarkMap& map, const FrameView& view, const std::vector<LandmarkMatch>& matches,
                              const Pose& guess, double noise, const LandmarkPoseOptions& options,
                              RandomStream& random) {
  std::vector<PointSighting> known, any;
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = map.landmarks()[size_t(match.landmark)];
    if (landmark.rho <= 0) continue;
    (landmark.Known() ? known : any).push_back({map.Place(landmark), view.xy[size_t(match.feature)]});
  }
  constexpr size_t kPlenty = 4;  // times the inliers needed; after a turn on the spot hardly any depth is known
  if (known.size() < kPlenty * size_t(options.min_inliers)) known.insert(known.end(), any.begin(), any.end());
  RansacOptions robustly{noise * options.threshold, options.confidence, options.iterations};
  robustly.min_iterations = 5;
  const auto found = EstimateAbsolutePose(known, robustly, random, guess);
  if (int(found.inliers.size()) < options.min_inliers) return {};
  return found.model;
}

std::optional<LandmarkPose> Agree(const LandmarkMap& map, const FrameView& view,
                                  const std::vector<LandmarkMatch>& matches, const Pose& guess, double noise,
                                  const LandmarkPoseOptions& options, RandomStream& random) {
  const std::optional<Pose> rough = RoughPose(map, view, matches, guess, noise, options, random);
  if (!rough) return {};
  std::vector<InverseDepthSighting> sightings;
  for (const LandmarkMatch& match : matches) sightings.push_back(SightingOf(map, view, match, noise));
  Pose pose = *rough;
  std::vector<int> inliers;
  constexpr int kRounds = 3;  // each refinement lets in what agrees with it
  for (int round = 0; round < kRounds; ++round) {
    inliers.clear();
    for (int i = 0; i < int(sightings.size()); ++i) {
      if (Mahalanobis2(sightings[size_t(i)], pose) < Square(options.outlier_sigmas)) inliers.push_back(i);
    }
    if (int(inliers.size()) < options.min_inliers) return {};
    pose = RefinePose(sightings, inliers, pose, 2);
  }
  LandmarkPose placed{pose, {}};
  for (const int i : inliers) placed.inliers.push_back(matches[size_t(i)]);
  return placed;
}

}  // namespace

std::optional<LandmarkPose> PlaceByLandmarks(const LandmarkMap& map, const FrameView& view, const Pose& prediction,
                                             double noise, const LandmarkPoseOptions& options, RandomStream& random) {
  auto placed = Agree(map, view, SearchNear(map, view, prediction, options.search), prediction, noise, options, random);
  if (!placed) {
    placed = Agree(map, view, SearchAnywhere(map, view, options.search.ratio), prediction, noise, options, random);
  }
  if (!placed) return {};
  const auto matches = SearchNear(map, view, placed->X_WC, Closely(options, noise));
  return Agree(map, view, matches, placed->X_WC, noise, options, random);
}

std::vector<LandmarkMatch> FindLandmarks(const LandmarkMap& map, const FrameView& view,
                                         const LandmarkPoseOptions& options) {
  std::vector<LandmarkMatch> matches = SearchNear(map, view, view.X_WC, Closely(options, 1));
  std::erase_if(matches, [&](const LandmarkMatch& match) {
    return Mahalanobis2(SightingOf(map, view, match, 1), view.X_WC) >= Square(options.outlier_sigmas);
  });
  return matches;
}

double NoiseFactor(const LandmarkMap& map, const FrameView& view, const std::vector<LandmarkMatch>& matches) {
  GAITCAM_ASSERT(!matches.empty());
  std::vector<double> distances;
  for (const LandmarkMatch& match : matches) {
    distances.push_back(std::sqrt(Mahalanobis2(SightingOf(map, view, match, 1), view.X_WC)));
  }
  std::nth_element(distances.begin(), distances.begin() + long(distances.size() / 2), distances.end());
  constexpr double kMedianOfRayleigh = 1.1774;  // of the length of a vector of two unit normals
  return distances[distances.size() / 2] / kMedianOfRayleigh;
}

}  // namespace gaitcam
