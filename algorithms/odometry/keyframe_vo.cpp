#include "algorithms/odometry/keyframe_vo.h"

#include <optional>
#include <utility>

#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/odometry/floor_prior.h"
#include "algorithms/odometry/frame_records.h"
#include "algorithms/odometry/keyframe_map.h"

namespace gaitcam {
namespace {

KeyframeMapOptions MapOptions(const KeyframeVoOptions& o) {
  KeyframeMapOptions options;
  options.window = o.window;
  options.memory = o.memory;
  options.adjust_iterations = o.adjust_iterations;
  constexpr double kSlack = 0.5;  // what a pose was estimated from is not removed at once
  options.outlier_sigmas = o.localizer.outlier_sigmas + kSlack;
  return options;
}

}  // namespace

class KeyframeVo::Tracker {
 public:
  Tracker(const Calibration& calibration, const KeyframeVoOptions& options, uint64_t seed)
      : calibration_(calibration),
        camera_(calibration.camera),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "frame_to_frame_vo"),  // an old name: with another all results would be other samples
        initializer_(camera_, options.initializer),
        localizer_(camera_.fx, options.initializer.matching.ratio, options.localizer),
        policy_(options.policy, camera_.fx, options.localizer.min_inliers),
        map_(MapOptions(options)) {}

  FrameEstimate Track(const Observation& observation) {
    const FrameEstimate answer = Answer(observation);
    records_.Add(answer, map_);
    if (HasMap() && !waiting_.empty()) LocalizeWaiting(observation.stamp_ns);
    return answer;
  }
  std::vector<FrameEstimate> Finish() const { return records_.Finish(map_); }

 private:
  /// A frame that has no pose in the map yet.
  struct PendingFrame {
    size_t record = 0;  ///< Index in records_.
    FrameView view;
    int64_t stamp_ns = 0;
  };

  bool HasMap() const { return map_.LatestKeyframe() >= 0; }
  KeyframeMap::DepthPriorOf DepthPriors() const {
    return [this](const Pose& X_WC, const Eigen::Vector2d& xy) { return floor_.DepthAt(X_WC, xy); };
  }
  PositionPrior PredictPosition(int64_t stamp_ns) const {
    return localizer_.PredictPosition(last_->pose.translation, stamp_ns - last_->stamp_ns, median_depth_);
  }

  FrameEstimate Answer(const Observation& observation);
  bool Initialize(FrameView& view);
  Pose PredictPose(const Observation& observation) const;
  bool Localize(FrameView& view, const Observation& observation);
  void Extend(FrameView& view, int64_t stamp_ns);
  void AddKeyframe(FrameView& view);
  void Postpone(const FrameView& view, int64_t stamp_ns);
  void LocalizeWaiting(int64_t stamp_ns);
  void LocalizeMissed(const FrameView& view, int64_t stamp_ns);
  void GiveUpMap();

  Calibration calibration_;
  CameraModel camera_;
  KeyframeVoOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;

  MapInitializer initializer_;
  LandmarkLocalizer localizer_;
  KeyframePolicy policy_;
  KeyframeMap map_;
  FloorPrior floor_;
  FrameRecords records_;

  std::vector<LandmarkMatch> inliers_;  ///< Of the present frame.
  std::optional<StampedPose> last_;     ///< The last known pose, over all maps.
  double median_depth_ = 1;             ///< In the last keyframe; the unit when a map is initialised.
  int lost_frames_ = 0;                 ///< Frames in a row that could not be localised in the map.
  bool is_restart_due_ = false;         ///< A map was given up: the next pose is in another.
  Pose X_WR_;                           ///< Of the initialiser's reference.
  std::vector<PendingFrame> waiting_;   ///< Since the initialiser's reference, while there is no map.
  std::vector<PendingFrame> missed_;    ///< Since the last frame that was localised in the map.
};

FrameEstimate KeyframeVo::Tracker::Answer(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = ViewFrame(observation.image.pixels, camera_, *detector_, options_.max_features,
                             {options_.localizer.sigma_px, options_.localizer.sigma_per_size});
  answer.features = view.features.size();
  inliers_.clear();
  const bool had_map = HasMap();
  const bool found = had_map ? Localize(view, observation) : Initialize(view);
  answer.inliers = int(inliers_.size());
  if (!found || !HasMap()) Postpone(view, answer.stamp_ns);
  if (!found) {
    answer.status = last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (had_map && ++lost_frames_ > options_.max_lost_frames) GiveUpMap();
    return answer;
  }
  lost_frames_ = 0;
  answer.status = TrackingStatus::kTracking;
  answer.restarted = std::exchange(is_restart_due_, false);
  if (had_map) {
    answer.restarted = !LandmarkLocalizer::IsWithinReach(PredictPosition(answer.stamp_ns), view.X_WC);
    Extend(view, answer.stamp_ns);
  }
  answer.pose = view.X_WC;
  last_ = {answer.stamp_ns, view.X_WC};
  return answer;
}

/// Without a map. The unit of a new map is such that its median depth is the last map's, 1 at first.
/// @returns whether the frame has a pose
bool KeyframeVo::Tracker::Initialize(FrameView& view) {
  const MapInitializer::Result result = initializer_.Add(view, random_);
  if (result == MapInitializer::Result::kReference) {
    waiting_.clear();
    X_WR_ = last_ ? last_->pose : Pose();
  }
  if (result != MapInitializer::Result::kInitialized) {
    if (!options_.rotation_before_map || !initializer_.rotation()) return false;
    view.X_WC = X_WR_ * Pose(*initializer_.rotation(), {0, 0, 0});
    return true;
  }
  const InitialPair& pair = initializer_.pair();
  const double unit = median_depth_ / pair.median_depth;
  FrameView reference = pair.reference;
  reference.X_WC = X_WR_;
  view.X_WC = X_WR_ * Pose(pair.X_AB.rotation, unit * pair.X_AB.translation);
  map_.AddKeyframe(reference, {}, median_depth_, DepthPriors());  // landmark i is the reference's feature i
  for (size_t i = 0; i < pair.matches.size(); ++i) {
    if (pair.depths[i]) map_.SetDepth(pair.matches[i].landmark, 1 / (unit * *pair.depths[i]));
  }
  inliers_ = pair.matches;
  AddKeyframe(view);
  return true;
}

/// The last pose, its rotation integrated from the gyroscope if that is asked for.
Pose KeyframeVo::Tracker::PredictPose(const Observation& observation) const {
  Pose prediction = last_->pose;
  if (!options_.use_imu || lost_frames_ > 0) return prediction;
  const Eigen::Quaterniond R_CI = calibration_.imu.X_CI.rotation;
  for (size_t i = 1; i < observation.imu.size(); ++i) {
    const double dt = double(observation.imu[i].stamp_ns - observation.imu[i - 1].stamp_ns) * 1e-9;
    prediction.rotation = prediction.rotation * ExpSo3(R_CI * observation.imu[i].angular_rate * dt);
  }
  return prediction;
}

/// With a map: the map grows by a frame that has a pose in it.
void KeyframeVo::Tracker::Extend(FrameView& view, int64_t stamp_ns) {
  if (policy_.IsKeyframe(map_, view.X_WC, inliers_)) {
    AddKeyframe(view);
  } else {
    map_.Refresh(view, inliers_);
  }
  LocalizeMissed(view, stamp_ns);
}

/// In the map.
bool KeyframeVo::Tracker::Localize(FrameView& view, const Observation& observation) {
  PosePrediction prediction;
  prediction.X_WC = PredictPose(observation);
  prediction.prior = PredictPosition(observation.stamp_ns);
  prediction.expected_inliers = policy_.expected_inliers();
  const auto localized = localizer_.Localize(map_, view, prediction, random_);
  if (!localized) return false;
  view.X_WC = localized->X_WC;
  inliers_ = localized->inliers;
  return true;
}

/// Inliers become observations, all other features new landmarks.
void KeyframeVo::Tracker::AddKeyframe(FrameView& view) {
  if (!inliers_.empty()) ScaleNoise(map_, inliers_, view);
  map_.AddKeyframe(view, inliers_, median_depth_, DepthPriors());
  median_depth_ = map_.MedianDepth(view.X_WC, median_depth_);
  if (options_.use_floor) floor_.Update(map_, view.X_WC, random_);
  policy_.OnKeyframe(int(inliers_.size()));
}

void KeyframeVo::Tracker::Postpone(const FrameView& view, int64_t stamp_ns) {
  constexpr size_t kMaxFrames = 60;  // their features take memory
  std::vector<PendingFrame>& pending = HasMap() ? missed_ : waiting_;
  if (pending.size() < kMaxFrames) pending.push_back({records_.size(), view, stamp_ns});
}

/// Frames before the map's first pose, from the latest back to the first, for the final estimate.
void KeyframeVo::Tracker::LocalizeWaiting(int64_t stamp_ns) {
  PosePrediction prediction;
  prediction.X_WC = last_->pose;
  prediction.expected_inliers = double(inliers_.size());
  const size_t present = records_.size() - 1;
  size_t first = present;
  for (auto frame = waiting_.rbegin(); frame != waiting_.rend(); ++frame) {
    prediction.prior =
        localizer_.PredictPosition(prediction.X_WC.translation, stamp_ns - frame->stamp_ns, median_depth_);
    const auto localized = localizer_.LocalizeWithNoise(map_, frame->view, prediction, 1, random_);
    if (!localized || !LandmarkLocalizer::IsWithinReach(*prediction.prior, localized->X_WC)) continue;
    prediction.X_WC = localized->X_WC;
    stamp_ns = frame->stamp_ns;
    first = frame->record;
    records_.SetPose(first, *localized, map_);
  }
  records_.MoveRestart(present, first);
  waiting_.clear();
}

/// Frames between the last pose and this one, for the final estimate.
void KeyframeVo::Tracker::LocalizeMissed(const FrameView& view, int64_t stamp_ns) {
  for (const PendingFrame& frame : missed_) {
    const auto localized = localizer_.LocalizeBetween(map_, frame.view, frame.stamp_ns, *last_, {stamp_ns, view.X_WC},
                                                      median_depth_, policy_.mean_inliers(), random_);
    if (localized) records_.SetPose(frame.record, *localized, map_);
  }
  missed_.clear();
}

void KeyframeVo::Tracker::GiveUpMap() {
  map_.Clear();
  floor_.Clear();
  missed_.clear();
  initializer_.Reset();
  is_restart_due_ = true;
}

KeyframeVoOptions KeyframeVoOptions::WithFeature(const std::string& feature, double sensitivity) {
  KeyframeVoOptions options;
  options.feature = feature;
  options.sensitivity = sensitivity;
  return options;
}

KeyframeVo::KeyframeVo(const Calibration& calibration, const KeyframeVoOptions& options, uint64_t seed) {
  calibration.camera.Check();
  CheckFields(options, "keyframe_vo.");
  tracker_ = std::make_unique<Tracker>(calibration, options, seed);
}

KeyframeVo::~KeyframeVo() = default;

FrameEstimate KeyframeVo::Track(const Observation& observation) { return tracker_->Track(observation); }

std::vector<FrameEstimate> KeyframeVo::Finish() const { return tracker_->Finish(); }

}  // namespace gaitcam
