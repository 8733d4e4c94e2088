#include "algorithms/odometry/two_view_vo.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"
#include "algorithms/geometry/two_view.h"

namespace gaitcam {
namespace {

/// What steps 2 to 5 make of a pair of frames. Lengths are in units of its baseline.
struct Reconstruction {
  RelativeMotion motion;                ///< From the first camera to the second.
  std::vector<Match> matches;           ///< The inliers in front of both cameras: first frame, second frame.
  int candidates = 0;                   ///< Matches among which they were found.
  std::vector<Eigen::Vector2d> depths;  ///< Of each, in the two cameras.
};

}  // namespace

class TwoViewVo::Loop {
 public:
  Loop(const CameraModel& camera, const TwoViewVoOptions& options, uint64_t seed)
      : camera_(camera),
        options_(options),
        detector_(MakeFeature2d(options.feature)),
        random_(seed, "two_view_vo"),
        random_of_filter_(seed, "match_filter") {}

  FrameEstimate Track(const Observation& observation);

 private:
  RansacOptions Ransac(double threshold) const { return {threshold, options_.confidence, options_.max_iterations}; }
  std::optional<Reconstruction> Reconstruct(const FrameView& view);
  std::optional<double> Scale(const Reconstruction& reconstruction);
  void StoreDepths(const Reconstruction& reconstruction, double scale, size_t features);

  CameraModel camera_;
  TwoViewVoOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_, random_of_filter_;

  std::optional<FrameView> previous_;          ///< The frame before.
  std::vector<std::optional<double>> depths_;  ///< Of its features by the pair before; empty: there is no such pair.
  Pose X_WP_;                                  ///< Its pose, or the last known one.
  bool has_pose_ = false;                      ///< Any frame so far had a pose.
};

FrameEstimate TwoViewVo::Loop::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = ViewFrame(observation.image.pixels, camera_, *detector_, options_.max_features, {});  // step 1
  answer.features = view.features.size();
  const bool is_first_pair = depths_.empty();
  const auto reconstruction = Reconstruct(view);
  const auto scale = reconstruction ? Scale(*reconstruction) : std::nullopt;
  if (scale) {
    const Pose X_VP(Eigen::Quaterniond(reconstruction->motion.R), *scale * reconstruction->motion.t);
    X_WP_ = X_WP_ * X_VP.Inverse();
    answer.status = TrackingStatus::kTracking;
    answer.pose = X_WP_;
    answer.restarted = is_first_pair && has_pose_;
    answer.inliers = int(reconstruction->matches.size());
    answer.matches = reconstruction->candidates;
    has_pose_ = true;
    StoreDepths(*reconstruction, *scale, view.xy.size());
  } else {
    answer.status = is_first_pair ? TrackingStatus::kInitializing : TrackingStatus::kLost;
    if (has_pose_) answer.predicted = X_WP_;
    depths_.clear();
  }
  previous_ = std::move(view);
  return answer;
}

/// Steps 2 to 5.
std::optional<Reconstruction> TwoViewVo::Loop::Reconstruct(const FrameView& view) {
  if (!previous_) return {};
  const auto matches = FilterMatches(
      MatchDescriptors(previous_->features.descriptors, view.features.descriptors, options_.matching),  // step 2
      previous_->features, view.features, options_.filter, random_of_filter_);
  if (int(matches.size()) < options_.min_points) return {};
  std::vector<PointPair> pairs;
  for (const Match& match : matches) pairs.push_back({previous_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
  RansacOptions mlesac = Ransac(options_.threshold_px / camera_.fx);
  mlesac.estimator = RobustEstimator::kMlesac;
  mlesac.outlier_span = camera_.width_px / camera_.fx;  // a mismatch may lie anywhere in the image
  const auto found = EstimateEssential(pairs, mlesac, random_, EpipolarDistance2);  // steps 3 and 4
  if (int(found.inliers.size()) < options_.min_points) return {};
  Reconstruction result;
  result.candidates = int(matches.size());
  result.motion = ChooseByDepth(found.model, pairs, found.inliers);  // step 5
  for (const int i : found.inliers) {
    if (!InFront(result.motion, pairs[size_t(i)])) continue;
    result.matches.push_back(matches[size_t(i)]);
    result.depths.push_back(Depths(result.motion, pairs[size_t(i)]));
  }
  if (int(result.matches.size()) < options_.min_points) return {};
  return result;
}

/// Step 6: length of the baseline in units of the first pair's.
std::optional<double> TwoViewVo::Loop::Scale(const Reconstruction& reconstruction) {
  if (depths_.empty()) return 1.0;
  std::vector<double> log_ratios;
  for (size_t i = 0; i < reconstruction.matches.size(); ++i) {
    const std::optional<double> before = depths_[size_t(reconstruction.matches[i].a)];
    if (before) log_ratios.push_back(std::log(*before / reconstruction.depths[i].x()));
  }
  const auto solve = [&](const std::vector<int>& one) { return std::vector<double>{log_ratios[size_t(one[0])]}; };
  const auto error2 = [&](double log_scale, int i) { return std::pow(log_ratios[size_t(i)] - log_scale, 2); };
  const auto found = gaitcam::Ransac<double>(int(log_ratios.size()), 1, Ransac(std::log1p(options_.scale_tolerance)),
                                             random_, solve, error2);
  if (int(found.inliers.size()) < options_.min_points) return {};
  double mean = 0;
  for (const int i : found.inliers) mean += log_ratios[size_t(i)] / double(found.inliers.size());
  return std::exp(mean);
}

/// For step 6 of the next pair.
void TwoViewVo::Loop::StoreDepths(const Reconstruction& reconstruction, double scale, size_t features) {
  depths_.assign(features, std::nullopt);
  for (size_t i = 0; i < reconstruction.matches.size(); ++i) {
    depths_[size_t(reconstruction.matches[i].b)] = scale * reconstruction.depths[i].y();
  }
}

TwoViewVoOptions TwoViewVoOptions::OfCrowds() {
  TwoViewVoOptions options;
  options.feature = "surf";
  options.filter.filter = MatchFilterKind::kIcgm;
  return options;
}

TwoViewVo::TwoViewVo(const CameraModel& camera, const TwoViewVoOptions& options, uint64_t seed) {
  camera.Check();
  CheckFields(options, "two_view_vo.");
  loop_ = std::make_unique<Loop>(camera, options, seed);
}

TwoViewVo::~TwoViewVo() = default;

FrameEstimate TwoViewVo::Track(const Observation& observation) { return loop_->Track(observation); }

}  // namespace gaitcam
