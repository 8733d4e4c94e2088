#include "algorithms/odometry/landmark_pose.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/median.h"
#include "algorithms/geometry/absolute_pose.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;

/// Nearness tells most rivals apart.
double RatioNearby(double ratio) { return 0.5 + 0.5 * ratio; }

InverseDepthSighting SightingOf(const LandmarkMap& map, const FrameView& view, const LandmarkMatch& match,
                                double noise) {
  const size_t i = size_t(match.feature);
  return {map.Point(map.landmarks()[size_t(match.landmark)]), view.xy[i], noise * view.sigma[i]};
}

}  // namespace

/// One look at a frame, with one idea of its noise.
class LandmarkPlacer::Look {
 public:
  Look(const LandmarkPlacer& placer, const LandmarkMap& map, const FrameView& view, const LandmarkPoseGuess& guess,
       double noise, RandomStream& random)
      : options_(placer.options_),
        placer_(placer),
        map_(map),
        view_(view),
        guess_(guess),
        noise_(noise),
        fewest_(guess.fewest_inliers > 0 ? guess.fewest_inliers : placer.options_.min_inliers),
        random_(random) {}

  std::optional<LandmarkPose> Agree(const std::vector<LandmarkMatch>& matches, const Pose& guess) const;
  std::optional<LandmarkPose> AgreeNearby(const std::vector<LandmarkMatch>& matches, const Pose& guess,
                                          double radius) const;
  std::optional<LandmarkPose> AgreeClosely(const std::optional<LandmarkPose>& found) const;

 private:
  std::optional<Pose> RoughPose(const std::vector<LandmarkMatch>& matches, const Pose& guess) const;
  std::optional<LandmarkPose> Settle(const std::vector<LandmarkMatch>& matches,
                                     const std::vector<InverseDepthSighting>& sightings, Pose pose,
                                     const std::optional<PositionPrior>& prior) const;
  std::vector<InverseDepthSighting> Sightings(const std::vector<LandmarkMatch>& matches) const {
    std::vector<InverseDepthSighting> sightings;
    for (const LandmarkMatch& match : matches) sightings.push_back(SightingOf(map_, view_, match, noise_));
    return sightings;
  }

  const LandmarkPoseOptions& options_;
  const LandmarkPlacer& placer_;
  const LandmarkMap& map_;
  const FrameView& view_;
  const LandmarkPoseGuess& guess_;
  double noise_;
  int fewest_;  ///< Sightings that have to agree.
  RandomStream& random_;
};

/// The pose that most matches agree upon: where the camera is expected, else anywhere, if as many agree as usual.
std::optional<LandmarkPose> LandmarkPlacer::Look::Agree(const std::vector<LandmarkMatch>& matches,
                                                        const Pose& guess) const {
  if (guess_.prior) {
    auto nearby = AgreeNearby(matches, guess, options_.search_deg * kRadPerDeg);
    if (nearby) return nearby;
  }
  const std::optional<Pose> rough = RoughPose(matches, guess);
  if (!rough) return {};
  auto settled = Settle(matches, Sightings(matches), *rough, {});
  constexpr double kManyAsUsual = 0.5;
  if (settled && guess_.prior && double(settled->inliers.size()) <= kManyAsUsual * guess_.usual_inliers) return {};
  return settled;
}

/// The pose that most three-point hypotheses' sightings agree with: of landmarks whose depth is known, as far as there
/// are enough of them.
std::optional<Pose> LandmarkPlacer::Look::RoughPose(const std::vector<LandmarkMatch>& matches,
                                                    const Pose& guess) const {
  std::vector<PointSighting> known, any;
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = map_.landmarks()[size_t(match.landmark)];
    if (landmark.rho <= 0) continue;
    (landmark.Known() ? known : any).push_back({map_.Place(landmark), view_.xy[size_t(match.feature)]});
  }
  constexpr int kPlenty = 4;  // times the inliers needed; after a turn on the spot hardly any depth is known
  if (int(known.size()) < kPlenty * options_.min_inliers) known.insert(known.end(), any.begin(), any.end());
  constexpr double kThresholdPx = 3;
  RansacOptions robustly{kThresholdPx * noise_ / placer_.focal_px_, 0.999, 100, 5};
  const auto found = EstimateAbsolutePose(known, robustly, random_, guess);
  if (int(found.inliers.size()) < options_.min_inliers) return {};
  return found.model;
}

/// Where the camera is expected, a turn alone has to be found: the one that many more agree upon than would by chance.
std::optional<LandmarkPose> LandmarkPlacer::Look::AgreeNearby(const std::vector<LandmarkMatch>& matches,
                                                              const Pose& guess, double radius) const {
  const std::vector<InverseDepthSighting> sightings = Sightings(matches);
  const PositionPrior& prior = *guess_.prior;
  const TurnResult turn = EstimateTurn(sightings, prior, guess.rotation, M_PI * radius * radius, random_);
  constexpr double kSurprise = 4;  // standard deviations; many turns are tried
  const double enough = std::max(double(fewest_), turn.chance + kSurprise * std::sqrt(turn.chance));
  if (double(turn.inliers.size()) < enough) return {};
  auto settled = Settle(matches, sightings, RefinePose(sightings, turn.inliers, turn.X_WC, 2, prior), prior);
  if (settled && !IsWithinReach(prior, settled->X_WC)) return {};
  return settled;
}

/// Once more, with a narrow search from the pose found.
std::optional<LandmarkPose> LandmarkPlacer::Look::AgreeClosely(const std::optional<LandmarkPose>& found) const {
  if (!found) return {};
  constexpr double kRadiusPx = 5;
  const auto close = placer_.SearchOptions(kRadiusPx * noise_ / placer_.focal_px_, RatioNearby(placer_.ratio_));
  return Agree(SearchNear(map_, view_, found->X_WC, close), found->X_WC);
}

/// Refines a pose by all that agree with it.
std::optional<LandmarkPose> LandmarkPlacer::Look::Settle(const std::vector<LandmarkMatch>& matches,
                                                         const std::vector<InverseDepthSighting>& sightings, Pose pose,
                                                         const std::optional<PositionPrior>& prior) const {
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  std::vector<int> inliers;
  constexpr int kRounds = 3;  // each refinement lets in what agrees with it
  for (int round = 0; round < kRounds; ++round) {
    inliers.clear();
    for (int i = 0; i < int(sightings.size()); ++i) {
      if (Mahalanobis2(sightings[size_t(i)], pose) < limit2) inliers.push_back(i);
    }
    if (int(inliers.size()) < fewest_) return {};
    pose = RefinePose(sightings, inliers, pose, 2, prior);
  }
  LandmarkPose settled{pose, {}};
  for (const int i : inliers) settled.inliers.push_back(matches[size_t(i)]);
  return settled;
}

LandmarkSearchOptions LandmarkPlacer::SearchOptions(double radius, double ratio) const {
  LandmarkSearchOptions search;
  search.radius = radius;
  search.ratio = ratio;
  search.same_place = 2 / focal_px_;
  return search;
}

std::optional<LandmarkPose> LandmarkPlacer::Place(const LandmarkMap& map, const FrameView& view,
                                                  const LandmarkPoseGuess& guess, RandomStream& random) const {
  auto placed = PlaceWithNoise(map, view, guess, 1, random);
  return placed ? placed : PlaceWithNoise(map, view, guess, options_.noise_of_second_look, random);
}

/// Looks for landmarks where they should be, else anywhere; then once more, closely, from the pose found.
std::optional<LandmarkPose> LandmarkPlacer::PlaceWithNoise(const LandmarkMap& map, const FrameView& view,
                                                           const LandmarkPoseGuess& guess, double noise,
                                                           RandomStream& random) const {
  const Look look(*this, map, view, guess, noise, random);
  const LandmarkSearchOptions wide = SearchOptions(options_.search_deg * kRadPerDeg, ratio_);
  auto found = look.Agree(SearchNear(map, view, guess.X_WC, wide), guess.X_WC);
  if (!found) found = look.Agree(SearchAnywhere(map, view, ratio_), guess.X_WC);
  return look.AgreeClosely(found);
}

/// What moved fast looks like nothing else for certain: less distinct matches will do, if they are near enough.
std::optional<LandmarkPose> LandmarkPlacer::PlaceClosely(const LandmarkMap& map, const FrameView& view,
                                                         const LandmarkPoseGuess& guess, double noise,
                                                         RandomStream& random) const {
  const Look look(*this, map, view, guess, noise, random);
  constexpr double kCloser = 0.4;  // part of the usual radius
  const double radius = kCloser * options_.search_deg * kRadPerDeg;
  const auto near = SearchNear(map, view, guess.X_WC, SearchOptions(radius, RatioNearby(ratio_)));
  return look.AgreeClosely(look.AgreeNearby(near, guess.X_WC, radius));
}

std::optional<LandmarkPose> LandmarkPlacer::PlaceBetween(const LandmarkMap& map, const FrameView& view,
                                                         int64_t stamp_ns, const StampedPlace& before,
                                                         const StampedPlace& after, double median_depth,
                                                         double usual_inliers, RandomStream& random) const {
  const double part = double(stamp_ns - before.stamp_ns) / double(after.stamp_ns - before.stamp_ns);
  LandmarkPoseGuess guess;
  guess.X_WC = Pose(before.X_WC.rotation.slerp(part, after.X_WC.rotation),
                    (1 - part) * before.X_WC.translation + part * after.X_WC.translation);
  const int64_t apart_ns = std::min(stamp_ns - before.stamp_ns, after.stamp_ns - stamp_ns);
  guess.prior = Expect(guess.X_WC.translation, apart_ns, median_depth);
  constexpr double kBetween = 0.5;  // one neighbour would leave so much more open than two
  guess.prior->sigma *= kBetween;
  guess.usual_inliers = usual_inliers;
  guess.fewest_inliers = (options_.min_inliers + 1) / 2;
  constexpr double kNoiseOfBlur = 1.5;
  auto placed = Place(map, view, guess, random);
  if (!placed) placed = PlaceClosely(map, view, guess, kNoiseOfBlur, random);
  if (placed && !IsWithinReach(*guess.prior, placed->X_WC)) return {};
  return placed;
}

std::vector<LandmarkMatch> LandmarkPlacer::Find(const LandmarkMap& map, const FrameView& view) const {
  constexpr double kRadiusPx = 5;
  const auto close = SearchOptions(kRadiusPx / focal_px_, RatioNearby(ratio_));
  std::vector<LandmarkMatch> matches = SearchNear(map, view, view.X_WC, close);
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  std::erase_if(matches, [&](const LandmarkMatch& match) {
    return Mahalanobis2(SightingOf(map, view, match, 1), view.X_WC) >= limit2;
  });
  return matches;
}

void ScaleNoise(const LandmarkMap& map, const std::vector<LandmarkMatch>& matches, FrameView& view) {
  std::vector<double> distances;
  for (const LandmarkMatch& match : matches) {
    distances.push_back(std::sqrt(Mahalanobis2(SightingOf(map, view, match, 1), view.X_WC)));
  }
  constexpr double kMedianOfRayleigh = 1.1774;  // of the length of a vector of two unit normals
  const double factor = std::clamp(UpperMedian(std::move(distances)) / kMedianOfRayleigh, 0.5, 3.0);
  for (double& sigma : view.sigma) sigma *= factor;
}

}  // namespace gaitcam
