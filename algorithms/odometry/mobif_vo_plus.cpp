#include "algorithms/odometry/mobif_vo_plus.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/homography.h"
#include "algorithms/geometry/two_view.h"
#include "algorithms/odometry/floor_prior.h"
#include "algorithms/odometry/keyframe_map.h"
#include "algorithms/odometry/landmark_localizer.h"

namespace gaitcam {
namespace {

constexpr double kLevel = 0.82;  // cosine of the largest angle between a floor's normal and the camera's up: 35 degrees

/// Where a frame stands: its place relative to a keyframe, so that what is learnt of the keyframe later moves it too.
struct KeyframedRecord {
  FrameEstimate answer;
  int keyframe = -1;  ///< -1: no pose, or one given before there was a keyframe.
  Pose X_KC;
};

/// Two views of a plane allow two motions, and the few things that stand out of it may fail to tell which. In the false
/// one plane and motion have changed places: the one whose plane is level, as a floor is under a camera that is carried
/// roughly level, is the true one.
/// @param threshold in normalised coordinates
/// @returns nothing where no motion or both have a level plane, as when the camera moves straight down.
std::optional<TwoView> OverALevelPlane(const std::vector<PointPair>& pairs, const std::vector<int>& inliers,
                                       double threshold) {
  const auto H = EstimateHomographyRobustly(pairs, inliers, threshold / 2);
  if (!H) return {};
  std::optional<RelativeMotion> level;
  for (const PlaneMotion& plane : DecomposeHomography(*H)) {
    if (!(plane.t.norm() > 0) || plane.normal.y() < kLevel) continue;
    if (level) return {};
    level = RelativeMotion{plane.R, plane.t.normalized()};
  }
  if (!level) return {};
  TwoView two_view = DescribeTwoView(pairs, *level, threshold);
  two_view.planar = true;
  return two_view;
}

/// Whether no camera that is carried gets from there to here: believed because many landmarks say so, but marked.
bool IsJump(const PositionPrior& prior, const Pose& X_WC) {
  constexpr double kNeverCarried = 8;  // standard deviations: 5 median depths a second
  return (X_WC.translation - prior.position_W).norm() >= kNeverCarried * prior.sigma;
}

KeyframeMapOptions MapOptions(const MobifVoPlusOptions& o) {
  return {o.window, o.memory, o.adjust_iterations, o.landmarks.outlier_sigmas};
}

}  // namespace

class MobifVoPlus::Tracker {
 public:
  Tracker(const Calibration& calibration, const MobifVoPlusOptions& options, uint64_t seed)
      : calibration_(calibration),
        camera_(calibration.camera),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "mobif_vo_plus"),
        placer_(calibration.camera.fx, options.ratio, options.landmarks),
        map_(MapOptions(options)) {}

  FrameEstimate Track(const Observation& observation);
  std::vector<FrameEstimate> Finish();

 private:
  bool Start(FrameView& view);
  void PlaceWaiting();
  bool StartMap(FrameView& view, const std::vector<Match>& matches, const TwoView& two_view);
  void AddKeyframe(FrameView& view);
  KeyframeMap::DepthPriorOf Guess() const {
    return [this](const Pose& X_WC, const Eigen::Vector2d& xy) { return floor_.DepthAt(X_WC, xy); };
  }
  PositionPrior Expect(int64_t stamp_ns) const {
    return placer_.PredictPosition(X_WC_last_->translation, stamp_ns - last_ns_, median_depth_);
  }
  Pose Predict(const Observation& observation) const;
  bool Locate(FrameView& view, const Observation& observation);
  void PlaceMissed(const FrameView& view, int64_t stamp_ns);
  void Attach(size_t record, const Pose& X_WC);
  bool WantsKeyframe(const FrameView& view);
  bool IsKeyframeDue(const FrameView& view) const;
  void Record(const FrameEstimate& answer, const FrameView& view);

  Calibration calibration_;
  CameraModel camera_;
  MobifVoPlusOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;

  LandmarkLocalizer placer_;
  KeyframeMap map_;
  FloorPrior floor_;
  std::optional<FrameView> reference_;  ///< The first of the two frames that will start a map.
  struct Waiting {
    size_t record = 0;
    FrameView view;
    int64_t stamp_ns = 0;
  };
  std::vector<Waiting> waiting_;        ///< Frames since then, for the map to place once there is one.
  std::vector<Waiting> missed_;         ///< Frames without a pose since the last one that has one.
  std::vector<LandmarkMatch> inliers_;  ///< Of the present frame.
  int keyframe_ = -1;                   ///< The latest of the present map; -1: there is no map yet.
  int keyframe_inliers_ = 0;            ///< Most landmarks that a frame since the last keyframe saw.
  double usual_inliers_ = 0;            ///< Landmarks seen per frame, lately.
  double usual_before_ = 0;             ///< ... by the last keyframe itself.
  int waiting_frames_ = 0;              ///< Since a keyframe was due.
  std::optional<Pose> X_WC_last_;       ///< Last known pose, over all maps.
  int64_t last_ns_ = 0;                 ///< Its stamp.
  double median_depth_ = 1;             ///< At the last keyframe; the unit when a map begins.
  int lost_frames_ = 0;
  std::vector<KeyframedRecord> records_;
};

FrameEstimate MobifVoPlus::Tracker::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = ViewFrame(observation.image.pixels, camera_, *detector_, options_.max_features,
                             {options_.landmarks.sigma_px, options_.landmarks.sigma_per_size});
  answer.features = view.features.size();
  inliers_.clear();
  const bool had_map = keyframe_ >= 0, was_lost = lost_frames_ > options_.max_lost_frames;
  const bool found = had_map ? Locate(view, observation) : Start(view);
  answer.inliers = int(inliers_.size());
  if (found) {
    answer.status = TrackingStatus::kTracking;
    const bool is_jump = X_WC_last_ && IsJump(Expect(answer.stamp_ns), view.X_WC);
    answer.restarted = was_lost || is_jump;
    lost_frames_ = 0;
    if (had_map && WantsKeyframe(view)) {
      ScaleNoise(map_, inliers_, view);
      AddKeyframe(view);
    } else if (had_map) {  // the frames of a start were described when they became keyframes
      map_.Refresh(view, inliers_);
    }
    answer.pose = view.X_WC;
    if (had_map) PlaceMissed(view, answer.stamp_ns);
    X_WC_last_ = view.X_WC;
    last_ns_ = answer.stamp_ns;
  } else {
    if (had_map) missed_.push_back({records_.size(), view, answer.stamp_ns});
    answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (++lost_frames_ > options_.max_lost_frames && had_map) {
      map_.Clear();
      floor_.Clear();
      keyframe_ = -1;
      reference_.reset();
      waiting_.clear();
      missed_.clear();
    }
  }
  Record(answer, view);
  return answer;
}

/// Without a map: the camera is taken to turn on the spot, until it has moved enough to see parallax.
bool MobifVoPlus::Tracker::Start(FrameView& view) {
  const auto begin_here = [&] {
    if (view.features.size() < options_.min_start_points) {
      reference_.reset();
      return false;
    }
    view.X_WC = X_WC_last_.value_or(Pose());
    reference_ = view;
    waiting_.clear();
    return true;
  };
  if (!reference_) return begin_here();
  MatchingOptions matching;
  matching.ratio = options_.ratio;
  const auto matches = MatchDescriptors(reference_->features.descriptors, view.features.descriptors, matching);
  if (int(matches.size()) < options_.min_start_points) return begin_here();
  std::vector<PointPair> pairs;
  std::vector<InverseDepthSighting> sightings;
  for (const Match& match : matches) {
    const size_t a = size_t(match.a), b = size_t(match.b);
    pairs.push_back({reference_->xy[a], view.xy[b]});
    sightings.push_back({{reference_->X_WC, reference_->xy[a], reference_->sigma[a], 0, 0}, view.xy[b], view.sigma[b]});
  }
  TwoView two_view = EstimateTwoView(pairs, {2.0 / camera_.fx, 0.9999, 300, 20}, random_);
  bool ambiguous = two_view.alternative.has_value();
  if (two_view.planar && options_.use_floor) {
    const auto level = OverALevelPlane(pairs, two_view.inliers, 2.0 / camera_.fx);
    ambiguous = !level;
    if (level) two_view = *level;
  }
  if (int(two_view.inliers.size()) < options_.min_start_points) return begin_here();
  const bool moved = !two_view.rotation_only && !ambiguous;
  if (moved && two_view.parallax > options_.start_parallax_deg * kRadPerDeg &&
      two_view.direction_sigma < options_.start_direction_deg * kRadPerDeg && StartMap(view, matches, two_view)) {
    return true;
  }
  const Pose guess(reference_->X_WC.rotation * two_view.X_AB.rotation, reference_->X_WC.translation);
  view.X_WC = RefinePose(sightings, two_view.inliers, guess, 2);
  constexpr size_t kMostWaiting = 60;  // frames: their features take memory
  if (waiting_.size() < kMostWaiting) waiting_.push_back({records_.size(), view, 0});
  return true;
}

/// Reference and present frame become the first keyframes. The unit is such that the points' median depth is that of
/// the map before (1 at first).
bool MobifVoPlus::Tracker::StartMap(FrameView& view, const std::vector<Match>& matches, const TwoView& two_view) {
  const Eigen::Vector3d t = two_view.X_AB.translation;
  std::vector<LandmarkMatch> pairs;
  std::vector<double> depths;
  std::vector<Eigen::Vector3d> below;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    const Eigen::Vector3d a = reference_->xy[size_t(match.a)].homogeneous(),
                          b = two_view.X_AB.rotation * view.xy[size_t(match.b)].homogeneous();
    const Eigen::Vector3d normal = b.cross(t.cross(b));  // of the plane through b's ray that is square to t's side
    const double depth = t.dot(normal) / a.dot(normal);
    if (!(depth > 0) || !std::isfinite(depth)) continue;
    depths.push_back(depth);
    if (a.y() > 0) below.push_back(depth * a);
    pairs.push_back({match.a, match.b});
  }
  if (int(pairs.size()) < options_.min_start_points) return false;
  // Where the motion makes the floor a slope, wait for another.
  if (two_view.planar && options_.use_floor && !FindFloor(below, random_)) return false;
  const double unit = median_depth_ / UpperMedian(depths);
  map_.AddKeyframe(*reference_, {}, median_depth_, Guess());
  for (size_t i = 0; i < pairs.size(); ++i) map_.SetDepth(pairs[i].landmark, 1 / (unit * depths[i]));
  view.X_WC = reference_->X_WC * Pose(two_view.X_AB.rotation, unit * t);
  inliers_ = pairs;
  AddKeyframe(view);
  PlaceWaiting();
  inliers_ = pairs;
  return true;
}

/// Frames that were taken to turn on the spot are placed in the map that came of them, for the final word.
void MobifVoPlus::Tracker::PlaceWaiting() {
  for (Waiting& frame : waiting_) {
    PosePrediction guess;
    guess.X_WC = reference_->X_WC;
    const auto placed = placer_.LocalizeWithNoise(map_, frame.view, guess, 1, random_);
    if (placed) Attach(frame.record, placed->X_WC);
  }
  waiting_.clear();
}

void MobifVoPlus::Tracker::Attach(size_t record, const Pose& X_WC) {
  records_[record].keyframe = keyframe_;
  records_[record].X_KC = map_.keyframes()[size_t(keyframe_)].Inverse() * X_WC;
}

void MobifVoPlus::Tracker::AddKeyframe(FrameView& view) {
  keyframe_ = map_.AddKeyframe(view, inliers_, median_depth_, Guess());
  keyframe_inliers_ = 0;
  usual_before_ = double(inliers_.size());
  usual_inliers_ = 0;
  median_depth_ = map_.MedianDepth(view.X_WC, median_depth_);
  if (options_.use_floor) floor_.Update(map_, view.X_WC, random_);
}

/// Where the camera was, turned on as the gyroscope says if it is asked.
Pose MobifVoPlus::Tracker::Predict(const Observation& observation) const {
  Pose prediction = X_WC_last_.value_or(Pose());
  if (!options_.use_imu || lost_frames_ > 0) return prediction;
  const Eigen::Quaterniond R_CI = calibration_.imu.X_CI.rotation;
  for (size_t i = 1; i < observation.imu.size(); ++i) {
    const double dt = double(observation.imu[i].stamp_ns - observation.imu[i - 1].stamp_ns) * 1e-9;
    const Eigen::Vector3d w = R_CI * observation.imu[i].angular_rate * dt;
    const double angle = w.norm();
    if (angle > 0) prediction.rotation = prediction.rotation * Eigen::AngleAxisd(angle, w / angle);
  }
  return prediction;
}

/// With a map: the pose from its landmarks.
bool MobifVoPlus::Tracker::Locate(FrameView& view, const Observation& observation) {
  PosePrediction guess;
  guess.X_WC = Predict(observation);
  guess.prior = Expect(observation.stamp_ns);
  guess.expected_inliers = usual_inliers_ > 0 ? usual_inliers_ : usual_before_;
  const auto placed = placer_.Localize(map_, view, guess, random_);
  if (!placed) return false;
  view.X_WC = placed->X_WC;
  inliers_ = placed->inliers;
  keyframe_inliers_ = std::max(keyframe_inliers_, int(inliers_.size()));
  return true;
}

/// Frames that were lost between two that have a pose have better expectations now: for the final word.
void MobifVoPlus::Tracker::PlaceMissed(const FrameView& view, int64_t stamp_ns) {
  const StampedPose before{last_ns_, *X_WC_last_}, after{stamp_ns, view.X_WC};
  for (const Waiting& frame : missed_) {
    const auto placed = placer_.LocalizeBetween(map_, frame.view, frame.stamp_ns, before, after, median_depth_,
                                                usual_inliers_, random_);
    if (placed) Attach(frame.record, placed->X_WC);
  }
  missed_.clear();
}

/// A keyframe is due once the camera has moved, turned or lost sight of points; it is taken at the next frame that sees
/// at least as many points as usual: one in the middle of a jerk would place all new points badly.
bool MobifVoPlus::Tracker::WantsKeyframe(const FrameView& view) {
  const double inliers = double(inliers_.size());
  constexpr double kForgetting = 0.1;
  usual_inliers_ = usual_inliers_ > 0 ? (1 - kForgetting) * usual_inliers_ + kForgetting * inliers : inliers;
  if (waiting_frames_ == 0 && !IsKeyframeDue(view)) return false;
  ++waiting_frames_;
  const bool in_danger =
      usual_inliers_<2 * options_.landmarks.min_inliers, is_late = waiting_frames_> options_.max_wait_frames;
  constexpr double kGoodEnough = 0.7;  // part of the usual, once it is late
  const double enough = is_late ? kGoodEnough * usual_inliers_ : usual_inliers_;
  if (inliers < enough && !in_danger && waiting_frames_ <= 2 * options_.max_wait_frames) return false;
  waiting_frames_ = 0;
  return true;
}

bool MobifVoPlus::Tracker::IsKeyframeDue(const FrameView& view) const {
  if (usual_inliers_ < options_.keyframe_overlap * keyframe_inliers_) return true;
  const Pose& X_WK = map_.keyframes()[size_t(keyframe_)];
  if (RotationAngle(X_WK.rotation, view.X_WC.rotation) > options_.keyframe_turn_deg * kRadPerDeg) return true;
  return map_.MedianParallax(inliers_, X_WK.translation, view.X_WC.translation) >
         options_.keyframe_parallax_deg * kRadPerDeg;
}

void MobifVoPlus::Tracker::Record(const FrameEstimate& answer, const FrameView& view) {
  KeyframedRecord record{answer, -1, Pose()};
  if (answer.pose && keyframe_ >= 0) {
    record.keyframe = keyframe_;
    record.X_KC = map_.keyframes()[size_t(keyframe_)].Inverse() * view.X_WC;
  }
  records_.push_back(record);
}

/// Frames after a keyframe move with it.
std::vector<FrameEstimate> MobifVoPlus::Tracker::Finish() {
  std::vector<FrameEstimate> frames;
  for (const KeyframedRecord& record : records_) {
    FrameEstimate frame = record.answer;
    if (record.keyframe >= 0) {
      frame.pose = map_.keyframes()[size_t(record.keyframe)] * record.X_KC;
      frame.status = TrackingStatus::kTracking;
    }
    frames.push_back(frame);
  }
  return frames;
}

MobifVoPlus::MobifVoPlus(const Calibration& calibration, const MobifVoPlusOptions& options, uint64_t seed) {
  calibration.camera.Check();
  CheckFields(options, "mobif_vo_plus.");
  tracker_ = std::make_unique<Tracker>(calibration, options, seed);
}

MobifVoPlus::~MobifVoPlus() = default;

FrameEstimate MobifVoPlus::Track(const Observation& observation) { return tracker_->Track(observation); }

std::vector<FrameEstimate> MobifVoPlus::Finish() { return tracker_->Finish(); }

}  // namespace gaitcam
