#include "algorithms/odometry/keyframe_vo.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/psf_inertial.h"
#include "algorithms/geometry/gyro_turn.h"
#include "algorithms/geometry/shutter_turn.h"
#include "algorithms/odometry/floor_prior.h"
#include "algorithms/odometry/frame_records.h"
#include "algorithms/odometry/fused_rotations.h"
#include "algorithms/odometry/keyframe_map.h"
#include "algorithms/odometry/late_frames.h"
#include "algorithms/odometry/mean_velocity.h"
#include "algorithms/odometry/metric_answers.h"
#include "algorithms/odometry/sharp_frames.h"

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

/// @throws BadOption if so few are asked for that there will be no map.
int MaxFeatures(const KeyframeVoOptions& o, const CameraModel& camera) {
  constexpr int kLeast = 50, kUsual = 800;
  constexpr double kUsual_px = 320 * 240;
  if (o.max_features > 0) {
    if (o.max_features < kLeast)
      throw BadOption("max_features: " + std::to_string(o.max_features) + " is too few; expected 0, or 50 to 100000");
    return o.max_features;
  }
  const double share = double(camera.width_px) * camera.height_px / kUsual_px;
  return int(std::lround(kUsual * std::max(1.0, share)));
}

constexpr int64_t kKeepImu_ns = 100'000'000;  // more than half an exposure, and than a period of the gyroscope

}  // namespace

class KeyframeVo::Tracker {
 public:
  Tracker(const Calibration& calibration, const KeyframeVoOptions& options, uint64_t seed)
      : calibration_(calibration),
        camera_(calibration.camera),
        options_(options),
        max_features_(MaxFeatures(options, camera_)),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        blur_aware_(dynamic_cast<BlurAwareFeature*>(detector_.get())),
        random_(seed, "frame_to_frame_vo"),  // an old name: with another all results would be other samples
        initializer_(camera_, options.initializer),
        localizer_(camera_.fx, options.initializer.matching.ratio, options.localizer),
        policy_(options.policy, options.localizer.min_inliers),
        map_(MapOptions(options)),
        late_(localizer_, map_, records_, seed) {
    if (options.metric && calibration.standing) metric_.emplace(calibration);
    const bool unrolls = options.shutter_by_imu && calibration.readout_ms > 0;
    if ((options.use_imu || options.blur_by_imu || unrolls) && calibration.imu.rate_hz > 0)
      gyro_.emplace(calibration.imu);
    if (options.use_imu && gyro_) fused_.emplace(calibration.imu);
    CheckBlurOptions();
    if (options.min_blur_px > 0) blur_aware_->SetMinBlur(options.min_blur_px);
  }

  FrameEstimate Track(const Observation& observation) {
    if (metric_) metric_->Add(observation.imu);
    if (gyro_) gyro_->Add(observation.imu);
    if (fused_) fused_->Begin(observation);
    FrameEstimate answer = Answer(observation);
    records_.Add(answer, map_);
    if (fused_ && answer.pose) answer.pose->rotation = *fused_->Present();
    if (gyro_) gyro_->DropBefore((last_ ? last_->stamp_ns : observation.stamp_ns) - kKeepImu_ns);
    if (HasMap() && late_.HasWaiting())
      late_.BeginBacklog({observation.stamp_ns, last_->pose}, median_depth_, double(inliers_.size()));
    late_.LocalizeOne();
    return metric_ ? metric_->InMetres(answer, HasMap()) : answer;
  }
  std::vector<FrameEstimate> Finish() {
    late_.LocalizeAll();
    std::vector<FrameEstimate> frames = records_.Finish(map_, metric_ ? metric_->Smoothed() : std::vector<double>());
    if (fused_) fused_->Smooth(frames);
    return frames;
  }

 private:
  /// How the camera turned between two instants, by the gyroscope.
  struct Turned {
    int64_t since_ns = 0, until_ns = 0;
    Eigen::Quaterniond rotation;  ///< Maps directions of the camera at the end into it at the beginning.
  };

  bool HasMap() const { return map_.LatestKeyframe() >= 0; }
  KeyframeMap::DepthPriorOf DepthPriors() const {
    return [this](const Pose& X_WC, const Eigen::Vector2d& xy) { return floor_.DepthAt(X_WC, xy); };
  }
  PositionPrior PredictPosition(int64_t stamp_ns) const {
    const int64_t apart_ns = stamp_ns - last_->stamp_ns;
    return localizer_.PredictPosition(last_->pose.translation + velocity_.Advance(apart_ns), apart_ns, median_depth_);
  }

  std::optional<Eigen::Vector3d> UpNow() const { return metric_ ? std::optional(metric_->up_C()) : std::nullopt; }

  FrameEstimate Answer(const Observation& observation);
  void CheckBlurOptions() const;
  int ChooseSaddles(const Observation& observation);
  void TellBlur(const Observation& observation);
  void Unroll(int64_t stamp_ns, FrameView& view) const;
  void HoldRotation(FrameView& view, int64_t stamp_ns);
  void LearnBias(const Pose& X_WC, int64_t stamp_ns);
  bool Initialize(FrameView& view, int64_t stamp_ns, std::optional<Pose>& predicted);
  std::optional<KnownTurn> TurnSinceReference(int64_t stamp_ns);
  std::optional<Eigen::Quaterniond> RotationByGyro(int64_t stamp_ns) const;
  Pose PredictPose(int64_t stamp_ns) const;
  Pose BeginPose(int64_t stamp_ns) const;
  bool Localize(FrameView& view, const Observation& observation);
  void Extend(FrameView& view, int64_t stamp_ns);
  void AddKeyframe(FrameView& view, int64_t stamp_ns);
  void GiveUpMap();

  Calibration calibration_;
  CameraModel camera_;
  KeyframeVoOptions options_;
  int max_features_;  ///< Of a frame.
  cv::Ptr<cv::Feature2D> detector_;
  BlurAwareFeature* blur_aware_;  ///< The same, where it accounts for blur.
  RandomStream random_;

  MapInitializer initializer_;
  LandmarkLocalizer localizer_;
  KeyframePolicy policy_;
  KeyframeMap map_;
  FloorPrior floor_;
  FrameRecords records_;
  LateFrames late_;
  std::optional<MetricAnswers> metric_;  ///< Where it is known how high the camera stands.
  std::optional<GyroTurn> gyro_;         ///< Where it is asked for and there is one.
  std::optional<Turned> turned_;         ///< Since the initialiser's reference, as far as it was measured.
  std::optional<FusedRotations> fused_;  ///< With use_imu.

  SharpFrames sharp_{0.1};  // grain and what comes into view change the detail of frames that are equally sharp
  ClearWalk clear_;
  bool is_sharp_ = true;                ///< The present frame is among the sharper ones.
  std::vector<LandmarkMatch> inliers_;  ///< Of the present frame.
  int matches_ = 0;                     ///< Likewise; 0 where there was no map yet.
  MeanVelocity velocity_;               ///< In the present map.
  std::optional<StampedPose> last_;     ///< The last known pose, over all maps.
  Pose expected_;                       ///< The same, or a later prediction of a frame without a map.
  double median_depth_ = 1;             ///< In the last keyframe; the unit when a map is initialised.
  int lost_frames_ = 0;                 ///< Frames in a row that could not be localised in the map.
  bool is_restart_due_ = false;         ///< A map was given up: the next pose is in another.
  Pose X_WR_;                           ///< Of the initialiser's reference.
};

FrameEstimate KeyframeVo::Tracker::Answer(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  CheckImageSize(observation.image.pixels, camera_);
  if (options_.blur_by_imu) TellBlur(observation);
  FrameView view = ViewFrame(observation.image.pixels, camera_, *detector_, ChooseSaddles(observation),
                             {options_.localizer.sigma_px, options_.localizer.sigma_per_size});
  if (options_.shutter_by_imu && gyro_ && calibration_.readout_ms > 0) Unroll(observation.stamp_ns, view);
  answer.features = view.features.size();
  inliers_.clear();
  matches_ = 0;
  const bool had_map = HasMap();
  const bool found = had_map ? Localize(view, observation) : Initialize(view, answer.stamp_ns, answer.predicted);
  answer.inliers = int(inliers_.size());
  answer.matches = matches_;
  if (!found) {
    answer.status = had_map ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (had_map) answer.predicted = PredictPose(answer.stamp_ns);
    if (fused_) fused_->Add({}, false);
    had_map ? late_.Miss(view, answer.stamp_ns) : late_.Wait(view, answer.stamp_ns);
    if (had_map && ++lost_frames_ > options_.max_lost_frames) GiveUpMap();
    return answer;
  }
  lost_frames_ = 0;
  answer.status = TrackingStatus::kTracking;
  answer.restarted = std::exchange(is_restart_due_, false);
  if (had_map) answer.restarted = !LandmarkLocalizer::IsWithinReach(PredictPosition(answer.stamp_ns), view.X_WC);
  if (fused_) fused_->Add(view.X_WC.rotation, answer.restarted);
  if (had_map) {
    if (fused_ && !answer.restarted) HoldRotation(view, answer.stamp_ns);
    if (gyro_ && !answer.restarted) LearnBias(view.X_WC, answer.stamp_ns);
    Extend(view, answer.stamp_ns);
  }
  answer.pose = view.X_WC;
  last_ = {answer.stamp_ns, view.X_WC};
  if (!had_map || answer.restarted) velocity_.Reset();
  velocity_.Add(*last_);
  expected_ = view.X_WC;
  return answer;
}

/// Without a map. The unit of a new map is such that its median depth is the last map's, 1 at first.
/// @param predicted set to the rotation alone, where that is asked for and there is no map yet
/// @returns whether there is a map now, and the frame has a pose in it
bool KeyframeVo::Tracker::Initialize(FrameView& view, int64_t stamp_ns, std::optional<Pose>& predicted) {
  const MapInitializer::Result result = initializer_.Add(view, UpNow(), TurnSinceReference(stamp_ns), random_);
  if (result == MapInitializer::Result::kReference) {
    late_.DropWaiting();
    X_WR_ = BeginPose(stamp_ns);
    turned_ = {stamp_ns, stamp_ns, Eigen::Quaterniond::Identity()};
  }
  if (result != MapInitializer::Result::kInitialized) {
    if (options_.rotation_before_map && initializer_.rotation()) {
      predicted = expected_ = X_WR_ * Pose(*initializer_.rotation(), {0, 0, 0});
    }
    return false;
  }
  const InitialPair& pair = initializer_.pair();
  const double unit = median_depth_ / pair.median_depth;
  FrameView reference = pair.reference;
  reference.X_WC = X_WR_;
  view.X_WC = X_WR_ * Pose(pair.X_AB.rotation, unit * pair.X_AB.translation);
  map_.AddKeyframe(reference, {}, median_depth_, DepthPriors());  // landmark i is the reference's feature i
  if (metric_) metric_->BeginMap();
  for (size_t i = 0; i < pair.matches.size(); ++i) {
    if (pair.depths[i]) map_.SetDepth(pair.matches[i].landmark, 1 / (unit * *pair.depths[i]));
  }
  inliers_ = pair.matches;
  AddKeyframe(view, stamp_ns);
  return true;
}

/// By the gyroscope, where there is one and it measured all the time: as far as its bias is known, and aligned by a
/// bench.
std::optional<KnownTurn> KeyframeVo::Tracker::TurnSinceReference(int64_t stamp_ns) {
  if (!gyro_ || !turned_) return {};
  const auto turn = gyro_->Between(turned_->until_ns, stamp_ns);
  if (!turn) {
    turned_.reset();
    return {};
  }
  turned_->until_ns = stamp_ns;
  turned_->rotation = (turned_->rotation * ExpSo3(*turn)).normalized();
  const double seconds = 1e-9 * double(stamp_ns - turned_->since_ns);
  const double angle = RotationAngle(Eigen::Quaterniond::Identity(), turned_->rotation);
  return KnownTurn{turned_->rotation, std::hypot(gyro_->bias_sigma() * seconds, BenchGyro::kMisaligned_rad * angle)};
}

/// Of the present frame: the last pose's, turned since as the gyroscope says.
/// @returns nothing where it did not measure. @pre there was a pose, and there is a gyroscope
std::optional<Eigen::Quaterniond> KeyframeVo::Tracker::RotationByGyro(int64_t stamp_ns) const {
  if (fused_) {
    if (const auto rotation = fused_->Predicted()) return rotation;
  }
  const auto turn = gyro_->Between(last_->stamp_ns, stamp_ns);
  if (!turn) return {};
  return last_->pose.rotation * ExpSo3(*turn);
}

/// With a map: the last pose, turned since by the gyroscope if rotations are by it, too.
Pose KeyframeVo::Tracker::PredictPose(int64_t stamp_ns) const {
  Pose prediction = last_->pose;
  if (fused_) prediction.rotation = RotationByGyro(stamp_ns).value_or(prediction.rotation);
  return prediction;
}

/// Of a frame with which a map may begin: where the map before it ended, turned since as the gyroscope says. Without
/// one a camera that turned while it saw nothing goes on in the direction in which it was lost.
Pose KeyframeVo::Tracker::BeginPose(int64_t stamp_ns) const {
  Pose begin = expected_;
  if (last_ && gyro_) begin.rotation = RotationByGyro(stamp_ns).value_or(begin.rotation);
  return begin;
}

/// Where a frame is blurred its image tells rotation and position badly apart; the gyroscope knows the rotation.
void KeyframeVo::Tracker::HoldRotation(FrameView& view, int64_t stamp_ns) {
  const Pose seen_from(fused_->SeenFrom(), view.X_WC.translation);
  view.X_WC = localizer_.Reposition(map_, view, inliers_, seen_from, PredictPosition(stamp_ns));
}

/// @param X_WC of the present frame
void KeyframeVo::Tracker::LearnBias(const Pose& X_WC, int64_t stamp_ns) {
  constexpr double kSigma_rad = 0.002;  // of the rotation between two frames
  const auto turn = gyro_->Between(last_->stamp_ns, stamp_ns);
  if (!turn) return;
  const Eigen::Quaterniond R_NL = X_WC.rotation.conjugate() * last_->pose.rotation;
  gyro_->LearnBias(LogSo3(R_NL * ExpSo3(*turn)), 1e-9 * double(stamp_ns - last_->stamp_ns), kSigma_rad);
}

/// @throws BadOption for options that this detector, camera or IMU has no use for.
void KeyframeVo::Tracker::CheckBlurOptions() const {
  for (const auto& [option, is_set] :
       {std::pair("min_blur_px", options_.min_blur_px > 0), std::pair("blur_by_imu", options_.blur_by_imu)})
    if (is_set && !blur_aware_)
      throw BadOption(std::string(option) + ": " + options_.feature + " does not account for blur");
  if (!options_.blur_by_imu) return;
  if (calibration_.readout_ms > 0) throw BadOption("blur_by_imu: needs a global shutter, this one rolls");
  if (!gyro_) throw BadOption("blur_by_imu: needs a gyroscope");
}

/// Judges the present frame's blur by its detail, and tells the detector what to do with saddle points.
/// @returns how many features the frame may have.
int KeyframeVo::Tracker::ChooseSaddles(const Observation& observation) {
  constexpr double kWithSaddles = 1.4375;  // so many that saddle points find room beside the usual number of blobs
  const double detail = FineDetail(observation.image.pixels);
  is_sharp_ = sharp_.Add(-detail);
  const bool is_clear = clear_.Add(observation.stamp_ns, detail, HasMap());
  if (!blur_aware_) return max_features_;
  const bool further = options_.saddles == SaddleTime::kClear && is_clear;
  const bool always = options_.saddles == SaddleTime::kAlways;
  blur_aware_->SetSaddleUse(further ? SaddleUse::kAfterBlobs : always ? SaddleUse::kByStrength : SaddleUse::kNone);
  return further ? int(kWithSaddles * max_features_) : max_features_;
}

/// Of the present frame's exposure; nothing where the gyroscope did not measure all of it.
void KeyframeVo::Tracker::TellBlur(const Observation& observation) {
  const int64_t half_ns = std::llround(0.5 * observation.exposure_ms * kNsPerMs);
  const int64_t open_ns = observation.stamp_ns - half_ns, close_ns = observation.stamp_ns + half_ns;
  if (half_ns == 0 || !gyro_->Between(open_ns, close_ns)) return blur_aware_->SetBlurRegions({});
  const Eigen::Vector3d bias_I = calibration_.imu.X_CI.rotation.conjugate() * gyro_->bias();
  const InertialPsf blur(gyro_->samples(), calibration_.imu, camera_, open_ns, close_ns, bias_I);
  blur_aware_->SetBlurRegions(blur.Regions());
}

/// Frames that the gyroscope did not measure stay as they are.
void KeyframeVo::Tracker::Unroll(int64_t stamp_ns, FrameView& view) const {
  const auto shutter = ShutterTurn::Measure(*gyro_, stamp_ns, calibration_.readout_ms);
  if (!shutter) return;
  for (size_t i = 0; i < view.xy.size(); ++i)
    view.xy[i] = shutter->AtStamp(view.xy[i], view.features.keypoints[i].pt.y / (camera_.height_px - 1.0));
}

/// With a map: the map grows by a frame that has a pose in it.
void KeyframeVo::Tracker::Extend(FrameView& view, int64_t stamp_ns) {
  const Pose& X_WK = map_.keyframes().back();
  const double parallax = map_.MedianParallax(inliers_, X_WK.translation, view.X_WC.translation);
  const double turn_rad = RotationAngle(X_WK.rotation, view.X_WC.rotation);
  if (policy_.IsKeyframe(stamp_ns, {camera_.fx * parallax, turn_rad, int(inliers_.size()), is_sharp_})) {
    AddKeyframe(view, stamp_ns);
  } else {
    map_.Refresh(view, inliers_);
    if (metric_) metric_->Follow(view.X_WC, stamp_ns);
  }
  late_.QueueMissed(*last_, {stamp_ns, view.X_WC}, median_depth_, policy_.mean_inliers());
}

/// In the map.
bool KeyframeVo::Tracker::Localize(FrameView& view, const Observation& observation) {
  PosePrediction prediction;
  prediction.X_WC = PredictPose(observation.stamp_ns);
  prediction.prior = PredictPosition(observation.stamp_ns);
  prediction.expected_inliers = policy_.expected_inliers();
  const auto localized = localizer_.Localize(map_, view, prediction, random_);
  if (!localized) return false;
  view.X_WC = localized->X_WC;
  inliers_ = localized->inliers;
  matches_ = localized->matches;
  return true;
}

/// Inliers become observations, all other features new landmarks.
void KeyframeVo::Tracker::AddKeyframe(FrameView& view, int64_t stamp_ns) {
  if (!inliers_.empty()) ScaleNoise(map_, inliers_, view);
  map_.AddKeyframe(view, inliers_, median_depth_, DepthPriors());
  median_depth_ = map_.MedianDepth(view.X_WC, median_depth_);
  policy_.OnKeyframe(int(inliers_.size()));
  if (metric_) {
    metric_->Follow(view.X_WC, stamp_ns);
    const auto measured = metric_->AddKeyframe(map_);
    if (options_.use_floor) floor_.Update(map_, view.X_WC, metric_->carried(), measured);
  } else if (options_.use_floor) {
    floor_.Update(map_, view.X_WC, random_);
  }
}

void KeyframeVo::Tracker::GiveUpMap() {
  late_.LocalizeAll();
  map_.Clear();
  floor_.Clear();
  late_.DropMissed();
  initializer_.Reset();
  is_restart_due_ = true;
  if (metric_) metric_->GiveUpMap();
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
