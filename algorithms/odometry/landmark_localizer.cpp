#include "algorithms/odometry/landmark_localizer.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/median.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/absolute_pose.h"

namespace gaitcam {
namespace {

/// A narrow search leaves few rivals: the ratio test is relaxed half-way to none.
double RatioNearby(double ratio) { return 0.5 + 0.5 * ratio; }

InverseDepthSighting SightingOf(const KeyframeMap& map, const FrameView& view, const LandmarkMatch& match,
                                double noise) {
  const size_t i = size_t(match.feature);
  const Landmark& landmark = map.landmarks()[size_t(match.landmark)];
  InverseDepthSighting sighting = {map.Point(landmark), view.xy[i], noise * view.sigma[i]};
  sighting.point.is_guess = !landmark.has_depth_prior && landmark.observations.empty();
  return sighting;
}

}  // namespace

/// One frame with one assumption about its noise.
class LandmarkLocalizer::Attempt {
 public:
  Attempt(const LandmarkLocalizer& localizer, const KeyframeMap& map, const FrameView& view,
          const PosePrediction& prediction, double noise, RandomStream& random)
      : options_(localizer.options_),
        localizer_(localizer),
        map_(map),
        view_(view),
        prediction_(prediction),
        noise_(noise),
        min_inliers_(prediction.min_inliers > 0 ? prediction.min_inliers : localizer.options_.min_inliers),
        random_(random) {}

  std::optional<LandmarkPose> FindConsensus(const std::vector<LandmarkMatch>& matches, const Pose& guess) const;
  std::optional<LandmarkPose> FindConsensusNearby(const std::vector<LandmarkMatch>& matches, const Pose& guess,
                                                  double radius) const;
  std::optional<LandmarkPose> RepeatWithNarrowSearch(const std::optional<LandmarkPose>& found) const;
  std::optional<LandmarkPose> RefineWithNarrowSearch(const LandmarkPose& found) const;

 private:
  std::vector<LandmarkMatch> SearchNarrowly(const Pose& X_WC) const;
  std::optional<Pose> ThreePointPose(const std::vector<LandmarkMatch>& matches, const Pose& guess) const;
  std::optional<LandmarkPose> RefineOverInliers(const std::vector<LandmarkMatch>& matches,
                                                const std::vector<InverseDepthSighting>& sightings, Pose pose,
                                                const std::optional<PositionPrior>& prior) const;
  std::vector<InverseDepthSighting> Sightings(const std::vector<LandmarkMatch>& matches) const {
    std::vector<InverseDepthSighting> sightings;
    for (const LandmarkMatch& match : matches) sightings.push_back(SightingOf(map_, view_, match, noise_));
    return sightings;
  }

  const LandmarkLocalizerOptions& options_;
  const LandmarkLocalizer& localizer_;
  const KeyframeMap& map_;
  const FrameView& view_;
  const PosePrediction& prediction_;
  double noise_;
  int min_inliers_;
  RandomStream& random_;
};

/// The pose with most inliers: near the prior, or else anywhere if enough of the expected inliers are found.
std::optional<LandmarkPose> LandmarkLocalizer::Attempt::FindConsensus(const std::vector<LandmarkMatch>& matches,
                                                                      const Pose& guess) const {
  if (prediction_.prior) {
    auto nearby = FindConsensusNearby(matches, guess, options_.search_deg * kRadPerDeg);
    if (nearby) return nearby;
  }
  const std::optional<Pose> rough = ThreePointPose(matches, guess);
  if (!rough) return {};
  auto refined = RefineOverInliers(matches, Sightings(matches), *rough, {});
  constexpr double kMinShare = 0.5;
  if (refined && prediction_.prior && double(refined->inliers.size()) <= kMinShare * prediction_.expected_inliers)
    return {};
  return refined;
}

/// P3P with RANSAC over the landmarks whose depth is known, and over the others too if those are few.
std::optional<Pose> LandmarkLocalizer::Attempt::ThreePointPose(const std::vector<LandmarkMatch>& matches,
                                                               const Pose& guess) const {
  std::vector<PointSighting> known, any;
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = map_.landmarks()[size_t(match.landmark)];
    if (landmark.rho <= 0) continue;
    (landmark.HasDepth() ? known : any).push_back({map_.Position(landmark), view_.xy[size_t(match.feature)]});
  }
  constexpr int kEnough = 4;  // times min_inliers; after a turn on the spot hardly any depth is known
  if (int(known.size()) < kEnough * options_.min_inliers) known.insert(known.end(), any.begin(), any.end());
  constexpr double kThresholdPx = 3;
  RansacOptions robustly{kThresholdPx * noise_ / localizer_.focal_px_, 0.999, 100, 5};
  const auto found = EstimateAbsolutePose(known, robustly, random_, guess);
  if (int(found.inliers.size()) < options_.min_inliers) return {};
  return found.model;
}

/// At the prior's position only a rotation is estimated. It is accepted if it has more inliers than chance would give.
std::optional<LandmarkPose> LandmarkLocalizer::Attempt::FindConsensusNearby(const std::vector<LandmarkMatch>& matches,
                                                                            const Pose& guess, double radius) const {
  const std::vector<InverseDepthSighting> sightings = Sightings(matches);
  const PositionPrior& prior = *prediction_.prior;
  const TurnResult turn = EstimateTurn(sightings, prior, guess.rotation, M_PI * radius * radius, random_);
  constexpr double kMinSigmas = 4;  // above the mean of a Poisson distribution; many rotations are tried
  const double required = std::max(double(min_inliers_), turn.chance + kMinSigmas * std::sqrt(turn.chance));
  if (double(turn.inliers.size()) < required) return {};
  auto refined =
      RefineOverInliers(matches, sightings, RefinePose(sightings, turn.inliers, turn.X_WC, kHuber, prior), prior);
  if (refined && !IsWithinReach(prior, refined->X_WC)) return {};
  return refined;
}

/// A circle of this radius holds 0.8 of 800 features of 320 x 240 px: what is alone in it passes the ratio test,
/// whatever it shows. Such matches lie near where the pose that was searched from has the landmark, and confirm it:
/// they need rivals from farther off.
std::vector<LandmarkMatch> LandmarkLocalizer::Attempt::SearchNarrowly(const Pose& X_WC) const {
  constexpr double kRadiusPx = 5, kRivalsPx = 20;
  const double px = noise_ / localizer_.focal_px_;
  LandmarkSearchOptions narrow = localizer_.SearchOptions(kRadiusPx * px, RatioNearby(localizer_.ratio_));
  narrow.rivals = kRivalsPx * px;
  return SearchNear(map_, view_, X_WC, narrow);
}

/// Searches again within a few pixels of where the landmarks project from the pose found.
std::optional<LandmarkPose> LandmarkLocalizer::Attempt::RepeatWithNarrowSearch(
    const std::optional<LandmarkPose>& found) const {
  if (!found) return {};
  return FindConsensus(SearchNarrowly(found->X_WC), found->X_WC);
}

/// The same for a pose near the prior that is beyond doubt: no other is tried.
std::optional<LandmarkPose> LandmarkLocalizer::Attempt::RefineWithNarrowSearch(const LandmarkPose& found) const {
  const std::vector<LandmarkMatch> matches = SearchNarrowly(found.X_WC);
  const auto refined = RefineOverInliers(matches, Sightings(matches), found.X_WC, prediction_.prior);
  if (refined && !IsWithinReach(*prediction_.prior, refined->X_WC)) return {};
  return refined;
}

/// Alternates between selecting the inliers of a pose and refining it over them.
std::optional<LandmarkPose> LandmarkLocalizer::Attempt::RefineOverInliers(
    const std::vector<LandmarkMatch>& matches, const std::vector<InverseDepthSighting>& sightings, Pose pose,
    const std::optional<PositionPrior>& prior) const {
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  std::vector<int> inliers;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    inliers.clear();
    const InverseDepthCamera camera(pose);
    for (int i = 0; i < int(sightings.size()); ++i) {
      if (Mahalanobis2(sightings[size_t(i)], camera) < limit2) inliers.push_back(i);
    }
    if (int(inliers.size()) < min_inliers_) return {};
    pose = RefinePose(sightings, inliers, pose, kHuber, prior);
  }
  LandmarkPose refined{pose, {}, int(matches.size())};
  for (const int i : inliers) refined.inliers.push_back(matches[size_t(i)]);
  return refined;
}

Pose LandmarkLocalizer::Reposition(const KeyframeMap& map, const FrameView& view,
                                   const std::vector<LandmarkMatch>& inliers, const Pose& X_WC,
                                   const PositionPrior& prior) const {
  std::vector<InverseDepthSighting> sightings;
  std::vector<int> all;
  for (const LandmarkMatch& match : inliers) {
    all.push_back(int(all.size()));
    sightings.push_back(SightingOf(map, view, match, 1));
  }
  return RefinePosition(sightings, all, X_WC, kHuber, prior);
}

LandmarkSearchOptions LandmarkLocalizer::SearchOptions(double radius, double ratio) const {
  LandmarkSearchOptions search;
  search.radius = radius;
  search.ratio = ratio;
  search.same_point = 2 / focal_px_;
  return search;
}

std::optional<LandmarkPose> LandmarkLocalizer::Localize(const KeyframeMap& map, const FrameView& view,
                                                        const PosePrediction& prediction, RandomStream& random) const {
  if (auto soon = LocalizeSoon(map, view, prediction, random)) return soon;
  Candidates candidates;
  auto localized = LocalizeAmong(candidates, map, view, prediction, 1, random);
  return localized ? localized : LocalizeAmong(candidates, map, view, prediction, options_.retry_noise_factor, random);
}

std::optional<LandmarkPose> LandmarkLocalizer::LocalizeWithNoise(const KeyframeMap& map, const FrameView& view,
                                                                 const PosePrediction& prediction, double noise,
                                                                 RandomStream& random) const {
  Candidates candidates;
  return LocalizeAmong(candidates, map, view, prediction, noise, random);
}

/// Most frames turn by less than the search allows for: half the radius has a quarter of the candidates. What is found
/// there counts if it has as many inliers as were to be expected, by half.
std::optional<LandmarkPose> LandmarkLocalizer::LocalizeSoon(const KeyframeMap& map, const FrameView& view,
                                                            const PosePrediction& prediction,
                                                            RandomStream& random) const {
  constexpr double kRadiusFactor = 0.5, kMinShare = 0.5;
  if (!prediction.prior || !(prediction.expected_inliers > 0)) return {};
  const Attempt attempt(*this, map, view, prediction, 1, random);
  const double radius = kRadiusFactor * options_.search_deg * kRadPerDeg;
  const auto near = SearchNear(map, view, prediction.X_WC, SearchOptions(radius, ratio_));
  const auto found = attempt.FindConsensusNearby(near, prediction.X_WC, radius);
  if (!found || double(found->inliers.size()) < kMinShare * prediction.expected_inliers) return {};
  return attempt.RefineWithNarrowSearch(*found);
}

/// Guided search around the predictions; if that fails, matching by descriptors alone (relocalisation).
std::optional<LandmarkPose> LandmarkLocalizer::LocalizeAmong(Candidates& candidates, const KeyframeMap& map,
                                                             const FrameView& view, const PosePrediction& prediction,
                                                             double noise, RandomStream& random) const {
  const Attempt attempt(*this, map, view, prediction, noise, random);
  if (!candidates.nearby) {
    const LandmarkSearchOptions wide = SearchOptions(options_.search_deg * kRadPerDeg, ratio_);
    candidates.nearby = SearchNear(map, view, prediction.X_WC, wide);
  }
  auto found = attempt.FindConsensus(*candidates.nearby, prediction.X_WC);
  if (!found) {
    if (!candidates.anywhere) candidates.anywhere = SearchAnywhere(map, view, ratio_);
    found = attempt.FindConsensus(*candidates.anywhere, prediction.X_WC);
  }
  return attempt.RepeatWithNarrowSearch(found);
}

/// Blur makes descriptors less distinct: the ratio test is relaxed and the search radius reduced instead.
std::optional<LandmarkPose> LandmarkLocalizer::LocalizeNearby(const KeyframeMap& map, const FrameView& view,
                                                              const PosePrediction& prediction, double noise,
                                                              RandomStream& random) const {
  const Attempt attempt(*this, map, view, prediction, noise, random);
  constexpr double kRadiusFactor = 0.4;
  const double radius = kRadiusFactor * options_.search_deg * kRadPerDeg;
  const auto near = SearchNear(map, view, prediction.X_WC, SearchOptions(radius, RatioNearby(ratio_)));
  return attempt.RepeatWithNarrowSearch(attempt.FindConsensusNearby(near, prediction.X_WC, radius));
}

std::optional<LandmarkPose> LandmarkLocalizer::LocalizeBetween(const KeyframeMap& map, const FrameView& view,
                                                               int64_t stamp_ns, const StampedPose& before,
                                                               const StampedPose& after, double median_depth,
                                                               double expected_inliers, RandomStream& random) const {
  const double part = double(stamp_ns - before.stamp_ns) / double(after.stamp_ns - before.stamp_ns);
  PosePrediction prediction;
  prediction.X_WC = Pose(before.pose.rotation.slerp(part, after.pose.rotation),
                         (1 - part) * before.pose.translation + part * after.pose.translation);
  const int64_t apart_ns = std::min(stamp_ns - before.stamp_ns, after.stamp_ns - stamp_ns);
  prediction.prior = PredictPosition(prediction.X_WC.translation, apart_ns, median_depth);
  constexpr double kInterpolated = 0.5;  // of the standard deviation that one neighbour alone would leave
  prediction.prior->sigma *= kInterpolated;
  prediction.expected_inliers = expected_inliers;
  prediction.min_inliers = (options_.min_inliers + 1) / 2;
  constexpr double kNoise = 1.5;
  auto localized = Localize(map, view, prediction, random);
  if (!localized) localized = LocalizeNearby(map, view, prediction, kNoise, random);
  if (localized && !IsWithinReach(*prediction.prior, localized->X_WC)) return {};
  return localized;
}

void ScaleNoise(const KeyframeMap& map, const std::vector<LandmarkMatch>& matches, FrameView& view) {
  std::vector<double> distances;
  for (const LandmarkMatch& match : matches) {
    distances.push_back(std::sqrt(Mahalanobis2(SightingOf(map, view, match, 1), view.X_WC)));
  }
  constexpr double kMedianOfRayleigh = 1.1774;  // length of a vector of two unit normals
  const double factor = std::clamp(UpperMedian(std::move(distances)) / kMedianOfRayleigh, 0.5, 3.0);
  for (double& sigma : view.sigma) sigma *= factor;
}

}  // namespace gaitcam
