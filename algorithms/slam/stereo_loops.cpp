#include "algorithms/slam/stereo_loops.h"

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/rig_pose.h"

namespace gaitcam {

StereoLoops::StereoLoops(const StereoLoopOptions& options, const LensUncertainty& lens, uint64_t seed)
    : options_(options), lens_(lens), random_(seed, "stereo_loops") {}

void StereoLoops::Keep(int keyframe, const StereoView& view, const StereoRig& rig) {
  constexpr double kOneDimension2 = 3.5 * 3.5;  // of a right match's reprojection error, squared
  Points points;
  std::vector<cv::Mat> rows;
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (view.partner[i] < 0) continue;
    const StereoPoint point = ReconstructPoint(rig, view.Sighting(i));
    if (!point.ok() || point.squared_error > kOneDimension2) continue;
    points.seen.push_back(view.SightingOf(i, point.p_L, point.covariance));
    rows.push_back(view.left.features.descriptors.row(int(i)));
  }
  if (!rows.empty()) cv::vconcat(rows, points.descriptors);
  LearnWords(view.left.features.descriptors);
  points.place = dictionary_->places() - 1;
  kept_[keyframe] = std::move(points);
}

/// The newest place, which shows these.
void StereoLoops::LearnWords(const cv::Mat& descriptors) {
  if (!dictionary_) {
    const bool bits = descriptors.type() == CV_8UC1;
    const double length = descriptors.empty() ? 1 : bits ? 8 * descriptors.cols : cv::norm(descriptors.row(0));
    DictionaryOptions options;
    options.max_distance = options_.word_radius * std::max(length, 1e-9);
    dictionary_.emplace(options);
  }
  last_words_ = KnownWords(dictionary_->Learn(descriptors));
  dictionary_->AddPlace(last_words_);
}

std::map<int, double> StereoLoops::LikeLast() const {
  std::map<int, double> likeness;
  if (!dictionary_) return likeness;
  const std::vector<double> score = dictionary_->Score(last_words_, dictionary_->places() - 1);
  for (const auto& [keyframe, points] : kept_) {
    if (points.place < score.size()) likeness[keyframe] = score[points.place];
  }
  return likeness;
}

std::optional<LoopMotion> StereoLoops::Match(int keyframe, const StereoView& view, const StereoRig& rig,
                                             const Pose& guess) {
  const auto kept = kept_.find(keyframe);
  GAITCAM_ASSERT(kept != kept_.end());
  const Points& points = kept->second;
  MatchingOptions matching;
  matching.ratio = options_.loop_ratio;
  std::vector<RigSighting> kept_sightings, sightings;
  for (const gaitcam::Match& match : MatchDescriptors(points.descriptors, view.left.features.descriptors, matching)) {
    const RigSighting& seen = points.seen[size_t(match.a)];
    kept_sightings.push_back(seen);
    sightings.push_back(view.SightingOf(size_t(match.b), seen.p_W, seen.covariance_W));
  }
  constexpr double kAnywhere_m = 2,
                   kAnywhere_rad = 1;  // so wide that it tells nothing: the odometry's share counts once
  const RigPosePrior prior{guess, kAnywhere_m, kAnywhere_rad};
  const auto found = EstimateRigPose(sightings, rig.X_LR, prior, options_.loop_inliers, {}, random_);
  if (!found || 100 * found->inliers < options_.loop_inlier_pct * double(sightings.size())) return std::nullopt;
  return LoopMotion{found->X_WC, found->covariance, LensErrorsOf(kept_sightings, sightings, *found, rig),
                    found->inliers, int(sightings.size())};
}

/// By the points that both frames saw with both cameras.
LensErrors StereoLoops::LensErrorsOf(const std::vector<RigSighting>& in_F, const std::vector<RigSighting>& in_T,
                                     const RigPoseResult& motion, const StereoRig& rig) const {
  if (lens_.IsExact()) return LensErrors::Zero();
  PointsInBoth points;
  for (size_t i = 0; i < in_T.size(); ++i) {
    if (motion.use[i] != SightingUse::kBoth) continue;
    points.A.push_back(in_F[i]);
    points.B.push_back(in_T[i]);
  }
  return LensErrorsOfMotion(points, rig, motion.X_WC, lens_);
}

}  // namespace gaitcam
