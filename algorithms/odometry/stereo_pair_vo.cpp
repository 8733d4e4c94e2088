#include "algorithms/odometry/stereo_pair_vo.h"

#include <optional>
#include <utility>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/geometry/error_propagation.h"
#include "algorithms/geometry/rigid_motion.h"

namespace gaitcam {
namespace {

/// The standard deviation is the scale, half a key point's diameter; blur has no say.
KeypointNoiseOptions ScaleAlone() {
  KeypointNoiseOptions noise;
  noise.sigma_px = 0;
  noise.sigma_per_size = 0.5;
  noise.sigma_per_blur = noise.sigma_across_blur = noise.sigma_per_noise = 0;
  return noise;
}

/// Features that have a partner, as points.
struct PointCloud {
  cv::Mat descriptors;
  std::vector<StereoPoint> points;
};

}  // namespace

class StereoPairVo::Loop {
 public:
  Loop(const Calibration& calibration, const StereoPairVoOptions& options, uint64_t seed)
      : rig_(StereoRig::Of(calibration)),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "stereo_pair_vo") {}

  FrameEstimate Track(const Observation& observation);

 private:
  struct Motion {
    Pose X_PC;  ///< From this frame into the one before.
    Matrix6d covariance;
    int inliers = 0;
  };
  PointCloud Reconstruct(const Observation& observation, int& features);
  std::optional<Motion> Align(const PointCloud& now);

  StereoRig rig_;
  StereoPairVoOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;
  bool is_first_ = true;
  std::optional<PointCloud> previous_;
  Pose X_WP_;  ///< Of the last frame that had a pose.
  Matrix6d covariance_ = Matrix6d::Zero();
  bool is_interrupted_ = false;  ///< A frame since then had none.
};

/// Steps 1 to 3.
PointCloud StereoPairVo::Loop::Reconstruct(const Observation& observation, int& features) {
  StereoView view = DetectInBoth(observation, rig_, *detector_, options_.max_features);
  features = int(view.left.size());
  UndoMotion(rig_.left, {}, {}, ScaleAlone(), view.left);
  UndoMotion(rig_.right, {}, {}, ScaleAlone(), view.right);
  if (is_first_) RefuseSwapped(rig_, view);
  view.partner = MatchStereo(rig_, view.left, view.right, options_.stereo);
  ReconstructionOptions algebraic;
  algebraic.cost = StereoCost::kAlgebraic;
  PointCloud cloud;
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (view.partner[i] < 0) continue;
    const StereoPoint point = ReconstructPoint(rig_, view.Sighting(i), algebraic);
    if (!point.ok()) continue;
    cloud.points.push_back(point);
    cloud.descriptors.push_back(view.left.features.descriptors.row(int(i)));
  }
  return cloud;
}

/// Steps 4 and 5.
std::optional<StereoPairVo::Loop::Motion> StereoPairVo::Loop::Align(const PointCloud& now) {
  std::vector<StereoPointMatch> pairs;
  std::vector<PointMatch> matches;
  for (const Match& match : MatchDescriptors(previous_->descriptors, now.descriptors, options_.matching)) {
    pairs.push_back({previous_->points[size_t(match.a)], now.points[size_t(match.b)]});
    matches.push_back(pairs.back().Match());
  }
  RigidMotionOptions options;
  options.method = RigidMotionMethod::kSvd;
  options.by_sigmas = false;
  options.ransac.threshold = options_.threshold_m;
  options.ransac.max_iterations = options_.max_iterations;
  options.min_inliers = options_.min_inliers;
  const RobustRigidMotion found = EstimateRigidMotion(matches, options, random_);
  if (!found.motion.ok()) return {};
  std::vector<StereoPointMatch> inliers;
  for (const int i : found.inliers) inliers.push_back(pairs[size_t(i)]);
  const PropagatedMotion error = PropagateMotion(inliers, found.motion.X_AB, MotionCost::kDistances);
  return Motion{found.motion.X_AB, error.covariance, int(inliers.size())};
}

FrameEstimate StereoPairVo::Loop::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  std::optional<PointCloud> cloud;
  if (IsPair(observation, is_first_)) cloud = Reconstruct(observation, answer.features);
  is_first_ = false;
  const bool begins = cloud && !previous_ && int(cloud->points.size()) >= options_.min_inliers;
  const auto motion = cloud && previous_ ? Align(*cloud) : std::nullopt;
  if (motion) {
    X_WP_ = X_WP_ * motion->X_PC;
    covariance_ = CarryCovariance(covariance_, motion->X_PC) + motion->covariance;
    answer.inliers = motion->inliers;
  }
  if (motion || begins) {
    answer.status = TrackingStatus::kTracking;
    answer.pose = X_WP_;
    answer.covariance = covariance_;
    answer.restarted = std::exchange(is_interrupted_, false);
    previous_ = std::move(cloud);
  } else {
    answer.status = previous_ || is_interrupted_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (answer.status == TrackingStatus::kLost) answer.predicted = X_WP_;
    is_interrupted_ = answer.status == TrackingStatus::kLost;
    previous_.reset();
  }
  return answer;
}

StereoPairVo::StereoPairVo(const Calibration& calibration, const StereoPairVoOptions& options, uint64_t seed) {
  CheckFields(options, "stereo_pair_vo.");
  StereoRig::Of(calibration).Check();
  loop_ = std::make_unique<Loop>(calibration, options, seed);
}

StereoPairVo::~StereoPairVo() = default;

FrameEstimate StereoPairVo::Track(const Observation& observation) { return loop_->Track(observation); }

}  // namespace gaitcam
