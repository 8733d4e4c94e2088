#include "algorithms/odometry/map_initializer.h"

#include <cmath>
#include <utility>

#include "algorithms/core/median.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "algorithms/geometry/inverse_depth.h"
#include "algorithms/geometry/triangulation.h"

namespace gaitcam {

MapInitializer::Result MapInitializer::Add(const FrameView& view, const std::optional<Eigen::Vector3d>& up_C,
                                           const std::optional<KnownTurn>& turn, RandomStream& random) {
  ++frames_;
  rotation_.reset();
  std::vector<Match> matches;
  std::vector<PointPair> pairs;
  if (reference_) {
    matches =
        FilterMatches(MatchDescriptors(reference_->features.descriptors, view.features.descriptors, options_.matching),
                      reference_->features, view.features, options_.filter, random);
    for (const Match& match : matches) pairs.push_back({reference_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
  }
  TwoView two_view;
  if (int(matches.size()) >= options_.min_start_points) two_view = Reconstruct(pairs, random);
  if (int(two_view.inliers.size()) < options_.min_start_points) {
    if (reference_ && ++misses_ <= options_.max_start_misses) return Result::kWaiting;
    misses_ = 0;
    reference_.reset();
    if (view.features.size() >= options_.min_start_points) {
      reference_ = view;
      reference_up_ = up_C;
      rotation_ = Eigen::Quaterniond::Identity();
    }
    return Result::kReference;
  }
  misses_ = 0;
  rotation_ = RotationAlone(view, matches, two_view);
  if (!IsCertain(two_view, turn) || !MakePair(view, matches, two_view)) return Result::kWaiting;
  frames_ = 0;
  return Result::kInitialized;
}

TwoView MapInitializer::Reconstruct(const std::vector<PointPair>& pairs, RandomStream& random) const {
  RansacOptions ransac{threshold(), options_.ransac_confidence, options_.ransac_iterations};
  ransac.estimator = options_.estimator;
  ransac.outlier_span = camera_.width_px / camera_.fx;  // a mismatch may lie anywhere in the image
  const auto found = EstimateEssential(pairs, ransac, random, EpipolarDistance2);
  constexpr size_t kMinInliers = 15;  // of fewer the refinement does not make a map's
  if (found.inliers.size() < kMinInliers) return {};
  return RefineTwoView(pairs, found.model, found.inliers, threshold(), reference_up_);
}

/// Maximum likelihood with all points at infinity.
Eigen::Quaterniond MapInitializer::RotationAlone(const FrameView& view, const std::vector<Match>& matches,
                                                 const TwoView& two_view) const {
  std::vector<InverseDepthSighting> sightings;
  for (const Match& match : matches) {
    const size_t a = size_t(match.a), b = size_t(match.b);
    sightings.push_back({{Pose(), reference_->xy[a], reference_->sigma[a], 0, 0}, view.xy[b], view.sigma[b]});
  }
  constexpr double kHuber = 2;  // standard deviations
  return RefinePose(sightings, two_view.inliers, Pose(two_view.X_AB.rotation, {0, 0, 0}), kHuber).rotation;
}

bool MapInitializer::IsCertain(const TwoView& two_view, const std::optional<KnownTurn>& turn) {
  if (two_view.rotation_only || two_view.alternative) return false;
  constexpr double kPlanarFactor = 5;  // any scene looks planar at little parallax
  const double needed_deg = options_.start_parallax_deg * (two_view.planar ? kPlanarFactor : 1);
  if (two_view.parallax < needed_deg * kRadPerDeg) return false;
  // Where all frames are blurred no direction is ever certain: the limit grows with time.
  const double patience = 1 + double(frames_) / options_.start_patience_frames;
  if (two_view.direction_sigma > patience * options_.start_direction_deg * kRadPerDeg) return false;
  return !turn || !Contradicts(two_view.X_AB.rotation, *turn);
}

/// One image may be wrong, not several in a row: then it is the turn that is not believed.
bool MapInitializer::Contradicts(const Eigen::Quaterniond& R_AB, const KnownTurn& turn) {
  constexpr double kImages_rad = 0.02, kSigmas = 3;
  constexpr int kMostInARow = 5;
  const bool contradicts = RotationAngle(R_AB, turn.R_AB) > kImages_rad + kSigmas * turn.sigma_rad;
  contradicted_ = contradicts ? contradicted_ + 1 : 0;
  return contradicts && contradicted_ <= kMostInARow;
}

bool MapInitializer::MakePair(const FrameView& view, const std::vector<Match>& matches, const TwoView& two_view) {
  pair_ = {};
  std::vector<double> known;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    pair_.matches.push_back({match.a, match.b});
    pair_.depths.push_back(Depth(two_view.X_AB, {reference_->xy[size_t(match.a)], view.xy[size_t(match.b)]}));
    if (pair_.depths.back()) known.push_back(*pair_.depths.back());
  }
  if (int(known.size()) < options_.min_start_points) return false;
  pair_.median_depth = UpperMedian(known);
  pair_.X_AB = two_view.X_AB;
  pair_.reference = std::move(*reference_);
  reference_.reset();
  return true;
}

/// In camera A, if the two rays meet at an angle and within the inliers' threshold.
std::optional<double> MapInitializer::Depth(const Pose& X_AB, const PointPair& pair) const {
  const std::vector<RayObservation> rays = {{Pose(), pair.a}, {X_AB, pair.b}};
  const auto p_A = TriangulatePoint(rays);
  if (!p_A || ParallaxAngle(*p_A, rays) < options_.min_parallax_deg * kRadPerDeg) return {};
  for (const RayObservation& ray : rays) {
    if (ReprojectionError(*p_A, ray) > threshold()) return {};
  }
  return p_A->z();
}

void MapInitializer::Reset() {
  reference_.reset();
  frames_ = misses_ = contradicted_ = 0;
}

}  // namespace gaitcam
