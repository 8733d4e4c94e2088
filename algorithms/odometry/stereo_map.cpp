#include "algorithms/odometry/stereo_map.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "algorithms/core/units.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/rig_projection.h"
#include "algorithms/odometry/feature_search.h"

namespace gaitcam {
namespace {

/// The baseline's length cannot be learnt from images: it is taken as calibrated.
constexpr double kExactTranslation_m = 1e-6;

}  // namespace

Matrix6d PositivePart(const Matrix6d& part, const Matrix6d& whole) {
  const Eigen::LLT<Matrix6d> factors(whole);
  if (factors.info() != Eigen::Success) return Matrix6d::Zero();
  const Matrix6d L = factors.matrixL();
  const Matrix6d left = factors.matrixL().solve(part);
  const Matrix6d whitened = factors.matrixL().solve(left.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(0.5 * (whitened + whitened.transpose()));
  const Vector6d values = eigen.eigenvalues().cwiseMax(0.0);
  const Matrix6d V = L * eigen.eigenvectors();
  return V * values.asDiagonal() * V.transpose();
}

/// What is refined together, and which of ours each of it is.
struct StereoMap::Window {
  struct Source {
    int landmark = 0, observation = 0;
  };
  StereoBundleProblem problem;
  std::vector<int> landmarks;   ///< Of each point.
  std::vector<Source> sources;  ///< Of each observation of the problem.
};

StereoMap::StereoMap(const StereoRig& rig, const StereoMapOptions& options)
    : rig_(rig), options_(options), prior_X_LR_(rig.X_LR), rig_covariance_(Matrix6d::Zero()) {
  if (options.rig_rotation_deg > 0) {
    rig_covariance_.diagonal().head<3>().setConstant(std::pow(kExactTranslation_m, 2));
    rig_covariance_.diagonal().tail<3>().setConstant(std::pow(kRadPerDeg * options.rig_rotation_deg, 2));
  }
}

int StereoMap::WindowBegin() const { return std::max(first_keyframe_, int(keyframes_.size()) - options_.window); }

RigSighting StereoMap::SightingOf(const StereoView& view, const StereoMatch& match) const {
  const StereoLandmark& landmark = landmarks_[size_t(match.landmark)];
  return view.SightingOf(size_t(match.feature), landmark.p_W, landmark.covariance_W);
}

std::vector<std::pair<int, RigSighting>> StereoMap::SightingsOf(int keyframe) const {
  std::vector<std::pair<int, RigSighting>> sightings;
  for (const int l : active_) {
    const StereoLandmark& landmark = landmarks_[size_t(l)];
    for (const StereoObservation& seen : landmark.observations) {
      if (seen.keyframe != keyframe) continue;
      sightings.emplace_back(l, seen.images);
      sightings.back().second.p_W = landmark.p_W;
      sightings.back().second.covariance_W = landmark.covariance_W;
    }
  }
  return sightings;
}

void StereoMap::AddKeyframe(const StereoView& view, const Pose& X_WC, const std::vector<StereoMatch>& matches,
                            const std::vector<SightingUse>& use) {
  const int keyframe = int(keyframes_.size());
  grown_.push_back(Matrix6d::Zero());
  keyframes_.push_back(X_WC);
  own_.push_back(Matrix6d::Zero());
  points_per_error_.push_back(view.points_per_error);
  for (size_t m = 0; m < matches.size(); ++m) {
    if (use[m] == SightingUse::kNone) continue;
    StereoLandmark& landmark = landmarks_[size_t(matches[m].landmark)];
    RigSighting images = SightingOf(view, matches[m]);
    images.has_right &= use[m] == SightingUse::kBoth;
    landmark.observations.push_back({keyframe, images});
    landmark.descriptor = view.left.features.descriptors.row(matches[m].feature).clone();
    landmark.latest = cv::Mat();
  }
  AddLandmarks(view, X_WC, matches);
  Adjust();
  GrowLensErrors();
  RetireUnseen();
}

/// Features that match a landmark but do not agree with it make no landmark: they are ambiguous.
void StereoMap::AddLandmarks(const StereoView& view, const Pose& X_WC, const std::vector<StereoMatch>& matches) {
  std::vector<bool> taken(view.left.size(), false);
  for (const StereoMatch& match : matches) taken[size_t(match.feature)] = true;
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  const Eigen::Matrix3d R = X_WC.R();
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (taken[i] || view.partner[i] < 0) continue;
    const StereoPoint point = ReconstructPoint(rig_, view.Sighting(i));
    if (!point.ok() || point.squared_error > limit2) continue;
    StereoLandmark landmark;
    landmark.p_W = X_WC * point.p_L;
    landmark.covariance_W = R * point.covariance * R.transpose();
    landmark.descriptor = view.left.features.descriptors.row(int(i)).clone();
    landmarks_.push_back(landmark);
    active_.push_back(int(landmarks_.size()) - 1);
    const RigSighting images = SightingOf(view, {active_.back(), int(i)});
    landmarks_.back().observations.push_back({int(keyframes_.size()) - 1, images});
  }
}

StereoMap::Window StereoMap::MakeWindow() const {
  Window window;
  const int begin = WindowBegin();
  window.problem.X_LR = rig_.X_LR;
  window.problem.prior_X_LR = prior_X_LR_;
  window.problem.prior_covariance = rig_covariance_;
  for (int k = begin; k < int(keyframes_.size()); ++k) {
    window.problem.cameras.push_back({keyframes_[size_t(k)], k == begin});
  }
  for (const int l : active_) {
    const StereoLandmark& landmark = landmarks_[size_t(l)];
    const int point = int(window.landmarks.size());
    for (size_t o = 0; o < landmark.observations.size(); ++o) {
      const StereoObservation& seen = landmark.observations[o];
      if (seen.keyframe < begin) continue;
      const auto add = [&](bool right, const Eigen::Vector2d& xy, const Eigen::Matrix2d& covariance) {
        window.problem.observations.push_back({seen.keyframe - begin, point, right, xy, covariance});
        window.sources.push_back({l, int(o)});
      };
      add(false, seen.images.left, seen.images.covariance_left);
      if (seen.images.has_right) add(true, seen.images.right, seen.images.covariance_right);
    }
    window.landmarks.push_back(l);
    window.problem.points.push_back(landmark.p_W);
  }
  return window;
}

void StereoMap::Adjust() {
  Window window = MakeWindow();
  StereoBundleOptions options;
  options.max_iterations = options_.adjust_iterations;
  const StereoBundleResult result = AdjustStereoBundle(window.problem, options);
  TakeOver(window, result);
  RemoveOutliers(window, result);
  if (!result.has_covariance) return;
  LearnRig(result);
  GrowShared(result);
}

void StereoMap::TakeOver(const Window& window, const StereoBundleResult& result) {
  const int begin = WindowBegin();
  for (size_t k = 0; k < window.problem.cameras.size(); ++k) {
    keyframes_[size_t(begin) + k] = window.problem.cameras[k].X_WC;
    own_[size_t(begin) + k] = result.own_covariances[k];
  }
  for (size_t i = 0; i < window.landmarks.size(); ++i) {
    StereoLandmark& landmark = landmarks_[size_t(window.landmarks[i])];
    landmark.p_W = window.problem.points[i];
    const Eigen::Matrix3d& covariance = result.point_covariances[i];
    landmark.determined = IsKnown(landmark.p_W, covariance);
    if (landmark.determined) landmark.covariance_W = covariance;
  }
  rig_.X_LR = window.problem.X_LR;
}

/// An observation of which an image does not fit is given up.
void StereoMap::RemoveOutliers(const Window& window, const StereoBundleResult& result) {
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  for (size_t k = window.sources.size(); k-- > 0;) {  // from the last one, so that numbers stay right
    if (result.errors2[k] < limit2) continue;
    auto& observations = landmarks_[size_t(window.sources[k].landmark)].observations;
    const auto at = observations.begin() + window.sources[k].observation;
    const int keyframe = window.problem.observations[k].camera + WindowBegin();
    if (at < observations.end() && at->keyframe == keyframe) observations.erase(at);
  }
}

/// What one window has learnt of the rig is the prior of those that share nothing with it.
void StereoMap::LearnRig(const StereoBundleResult& result) {
  if (rig_covariance_.isZero(0) || int(keyframes_.size()) - prior_keyframe_ < options_.window) return;
  prior_keyframe_ = int(keyframes_.size());
  prior_X_LR_ = rig_.X_LR;
  rig_covariance_ = result.rig_covariance;
}

/// The window says how well the newest keyframe is known relative to the oldest. Less what the images of these two
/// contribute, this is what the keyframes between have added, in equal parts.
void StereoMap::GrowShared(const StereoBundleResult& result) {
  const size_t newest = keyframes_.size() - 1, oldest = size_t(WindowBegin());
  if (newest == oldest) return;
  const Matrix6d& whole = result.camera_covariances.back();
  const Pose X_ON = keyframes_[oldest].Inverse() * keyframes_[newest];
  const Matrix6d grown = whole - own_[newest] - CarryCovariance(own_[oldest], X_ON);
  const double points_per_error =
      std::accumulate(points_per_error_.begin() + std::ptrdiff_t(oldest), points_per_error_.end(), 0.0) /
      double(newest - oldest + 1);
  grown_[newest] = points_per_error * PositivePart(grown, whole) / double(newest - oldest);
}

Matrix6d StereoMap::GrownBetween(int from, int to) const {
  Matrix6d sum = Matrix6d::Zero();
  const Pose X_TW = keyframes_[size_t(to)].Inverse();
  for (int k = from + 1; k <= to; ++k)
    sum += CarryCovariance(grown_[size_t(k)], (X_TW * keyframes_[size_t(k)]).Inverse());
  return sum;
}

LensErrors StereoMap::LensErrorsBetween(int from, int to) const {
  LensErrors errors = LensErrors::Zero();
  for (int k = from + 1; k <= to; ++k) {
    const Pose step = keyframes_[size_t(k - 1)].Inverse() * keyframes_[size_t(k)];
    errors = ChainLensErrors(errors, step, lens_errors_[size_t(k)]);
  }
  return errors;
}

LensErrors StereoMap::LensErrorsFrom(int keyframe, const std::vector<std::pair<int, RigSighting>>& sightings,
                                     const Pose& X_KC) const {
  if (options_.lens.IsExact()) return LensErrors::Zero();
  PointsInBoth points;
  for (const auto& [landmark, images] : sightings) {
    if (!images.has_right) continue;
    for (const StereoObservation& seen : landmarks_[size_t(landmark)].observations) {
      if (seen.keyframe != keyframe || !seen.images.has_right) continue;
      points.A.push_back(seen.images);
      points.B.push_back(images);
    }
  }
  return LensErrorsOfMotion(points, rig_, X_KC, options_.lens);
}

void StereoMap::GrowLensErrors() {
  lens_errors_.push_back(LensErrors::Zero());
  const int newest = int(keyframes_.size()) - 1;
  if (newest == first_keyframe_ || options_.lens.IsExact()) return;
  std::vector<std::pair<int, RigSighting>> sightings;
  for (const int l : active_) {
    const auto& observations = landmarks_[size_t(l)].observations;
    if (observations.empty() || observations.back().keyframe != newest) continue;
    sightings.emplace_back(l, observations.back().images);
  }
  const Pose step = keyframes_[size_t(newest - 1)].Inverse() * keyframes_[size_t(newest)];
  lens_errors_.back() = LensErrorsFrom(newest - 1, sightings, step);
}

/// Its distance from the camera is known to a part of it: observations that were given up may leave too few.
bool StereoMap::IsKnown(const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance) const {
  constexpr double kLeastKnown = 0.5;
  const double distance = (p_W - keyframes_.back().translation).norm();
  return covariance.allFinite() && covariance.llt().info() == Eigen::Success &&
         std::sqrt(covariance.trace()) < kLeastKnown * distance;
}

void StereoMap::RetireUnseen() {
  const int begin = WindowBegin();
  std::vector<int> still;
  for (const int l : active_) {
    StereoLandmark& landmark = landmarks_[size_t(l)];
    const bool is_seen = !landmark.observations.empty() && landmark.observations.back().keyframe >= begin;
    if (is_seen && landmark.determined) {
      still.push_back(l);
      continue;
    }
    landmark.retired = true;
    landmark.descriptor = landmark.latest = cv::Mat();
    landmark.observations = {};
  }
  active_ = std::move(still);
}

void StereoMap::Clear() {
  first_keyframe_ = int(keyframes_.size());
  RetireUnseen();
}

void StereoMap::Refresh(const StereoView& view, const std::vector<StereoMatch>& matches) {
  for (const StereoMatch& match : matches) {
    landmarks_[size_t(match.landmark)].latest = view.left.features.descriptors.row(match.feature).clone();
  }
}

std::vector<StereoMatch> StereoMap::SearchNear(const StereoView& view, const Pose& X_WC, double radius,
                                               double ratio) const {
  constexpr double kLeastCell = 0.02, kSigmas = 2, kSamePoint_px = 2;
  const FeatureGrid grid(view.left.xy, std::max(kLeastCell, radius));
  DescriptorSearch search(view.left.xy, view.left.features.descriptors, ratio, kSamePoint_px / rig_.left.fx);
  const Pose X_CW = X_WC.Inverse();
  std::vector<LandmarkClaim> claims(view.left.size());
  std::vector<int> candidates;
  for (const int l : active_) {
    const StereoLandmark& landmark = landmarks_[size_t(l)];
    const auto image = ProjectInRig(X_CW, nullptr, landmark.p_W);
    if (!image) continue;
    const Eigen::Matrix2d spread = image->by_point * landmark.covariance_W * image->by_point.transpose();
    candidates.clear();
    grid.Near(image->xy, radius + std::min(radius, kSigmas * std::sqrt(spread.trace())),
              [&](int i) { candidates.push_back(i); });
    const NearestFeature found = search.Find(landmark.descriptor, landmark.latest, candidates);
    if (found.feature < 0) continue;
    const LandmarkClaim claim = {l, landmark.observations.size(), found.distance};
    if (claims[size_t(found.feature)].landmark < 0 || claim.Beats(claims[size_t(found.feature)])) {
      claims[size_t(found.feature)] = claim;
    }
  }
  std::vector<StereoMatch> matches;
  for (size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].landmark >= 0) matches.push_back({claims[i].landmark, int(i)});
  }
  return matches;
}

std::vector<StereoMatch> StereoMap::SearchAnywhere(const StereoView& view, double ratio) const {
  if (active_.empty() || view.left.size() == 0) return {};
  cv::Mat descriptors;
  for (const int l : active_) descriptors.push_back(landmarks_[size_t(l)].descriptor);
  MatchingOptions matching;
  matching.ratio = ratio;
  std::vector<StereoMatch> matches;
  for (const Match& match : MatchDescriptors(descriptors, view.left.features.descriptors, matching)) {
    matches.push_back({active_[size_t(match.a)], match.b});
  }
  return matches;
}

}  // namespace gaitcam
