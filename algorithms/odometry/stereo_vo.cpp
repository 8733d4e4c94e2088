#include "algorithms/odometry/stereo_vo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/odometry/exposure_motion.h"
#include "algorithms/odometry/landmark_drift.h"
#include "algorithms/odometry/sharp_frames.h"
#include "algorithms/odometry/stereo_map.h"

namespace gaitcam {
namespace {

/// A pose is refined within this of where it was, m and rad: landmarks that are better known later move it less.
constexpr double kWide = 0.02;
/// A pose that is turned by more than this is not known.
constexpr double kTurnKnown_rad = 0.05;

StereoMapOptions MapOptions(const StereoVoOptions& o, const LensUncertainty& lens) {
  StereoMapOptions options;
  options.lens = lens;
  options.window = o.window;
  options.adjust_iterations = o.adjust_iterations;
  constexpr double kSlack = 0.5;  // what a pose was estimated from is not removed at once
  options.outlier_sigmas = o.outlier_sigmas + kSlack;
  options.rig_rotation_deg = o.rig_rotation_deg;
  return options;
}

/// The images say more of a pose than was known before them.
bool Supports(const Matrix6d& own, const RigPosePrior& prior) {
  return LargestSigma(own.topLeftCorner<3, 3>()) < prior.sigma_m &&
         LargestSigma(own.bottomRightCorner<3, 3>()) < kTurnKnown_rad;
}

}  // namespace

class StereoVo::Tracker {
 public:
  Tracker(const Calibration& calibration, const StereoVoOptions& options, uint64_t seed)
      : rig_(StereoRig::Of(calibration)),
        readout_ms_(options.shutter_by_imu ? calibration.readout_ms : 0),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "stereo_vo"),
        motion_(calibration.imu, options.use_imu),
        policy_(options.policy, options.min_inliers),
        lens_(calibration.lens),
        map_(rig_, MapOptions(options, lens_)) {
    pose_options_.outlier_sigmas = options.outlier_sigmas;
  }

  FrameEstimate Track(const Observation& observation);
  std::vector<FrameEstimate> Finish();
  Pose X_LR() const { return map_.rig().X_LR; }
  const StereoMap& map() const { return map_; }
  const StereoView* keyframe_view() const { return keyframe_view_ ? &*keyframe_view_ : nullptr; }

 private:
  /// A frame as the final estimate needs it.
  struct Record {
    FrameEstimate answer;
    int keyframe = -1;  ///< The latest when it was tracked; -1: no pose.
    Pose X_KC;
    LensErrors lens_errors = LensErrors::Zero();  ///< Of X_KC.
    Matrix6d unknown_motion = Matrix6d::Zero();
    Eigen::Matrix3d rate_covariance = Eigen::Matrix3d::Zero();  ///< Of the turn by which a rolling shutter was undone.
    double residuals_share = 1;
    std::vector<std::pair<int, RigSighting>> sightings;  ///< By landmark; the landmarks' positions are looked up.
  };
  /// What the frames before one pass on to it.
  struct Passed {
    LandmarkGains before;     ///< Of the frame before.
    GrowingCovariance grown;  ///< Live: that frames share. Final: by landmarks, since ...
    int keyframe = -1;        ///< ... this one.
  };
  /// A pose in the map.
  struct Localized {
    RigPoseResult result;
    std::vector<StereoMatch> matches;
  };

  std::optional<StereoView> View(const Observation& observation);
  void UndoMotionOfNear(const ImageMotion& of_left, const ImageMotion& of_right, StereoView& view) const;
  bool Begin(const StereoView& view, Record& record);
  bool Localize(const StereoView& view, Record& record);
  std::optional<Localized> FindPose(const StereoView& view);
  bool IsBeyondChance(const RigPoseResult& result, const std::vector<RigSighting>& sightings, double radius) const;
  std::optional<Localized> Refined(const StereoView& view, const Localized& rough, const RigPosePrior& prior) const;
  RigPosePrior Prior() const;
  std::vector<RigSighting> Sightings(const StereoView& view, const std::vector<StereoMatch>& matches) const;
  Pose PredictPose() const;
  SinceKeyframe CompareWithKeyframe(const Localized& found) const;
  void Extend(const StereoView& view, const Localized& found);
  void Remember(const StampedPose& known, double turn_sigma);
  void Lose(Record& record);

  void NoteKeyframe();
  void Answer(const RigPoseResult& result, const std::vector<int>& landmarks, Passed& passed, Record& record) const;
  Matrix6d SharedLive(int keyframe, const LandmarkGains& now, Passed& passed) const;
  Matrix6d SharedFinal(int keyframe, const LandmarkGains& now, Passed& passed) const;
  Eigen::Matrix<double, 6, 3> ByRate(const LandmarkGains& gains) const;
  void SayCovariance(const Matrix6d& own, const Matrix6d& shared, const Pose& X_KC, Record& record) const;
  void FinishBefore(int keyframe);
  void FinishRecord(Record& record);

  StereoRig rig_;      ///< As calibrated.
  double readout_ms_;  ///< To be undone; 0: nothing is.
  StereoVoOptions options_;
  RigPoseOptions pose_options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;
  ExposureMotion motion_;
  KeyframePolicy policy_;
  LensUncertainty lens_;
  StereoMap map_;
  std::optional<StereoView> keyframe_view_;  ///< Of the frame tracked last, if it became a keyframe.

  std::optional<StampedPose> last_;  ///< The last known pose.
  double last_turn_sigma_ = 0;       ///< Of its rotation, by its own images, rad; 0: a map begins there.
  int lost_frames_ = 0;
  SharpFrames sharp_{0};
  bool is_sharp_ = true;                      ///< The present frame is among the sharper ones.
  Passed live_, final_;                       ///< By the last frame, tracked and finished.
  std::map<int, LandmarkGains> at_keyframe_;  ///< Of the keyframes of which frames are not finished.
  std::vector<Record> records_;
  size_t finished_ = 0;  ///< So many of the records.
};

FrameEstimate StereoVo::Tracker::Track(const Observation& observation) {
  Record record;
  record.answer.stamp_ns = observation.stamp_ns;
  motion_.Add(observation);
  keyframe_view_.reset();
  if (const auto view = View(observation)) {
    record.answer.features = int(view->left.size());
    record.unknown_motion = motion_.UnknownMotion(options_.noise.common_per_blur);
    record.rate_covariance = motion_.RateCovariance(readout_ms_);
    is_sharp_ = sharp_.Add(motion_.Extent());
    record.residuals_share =
        options_.noise.residuals_share + options_.noise.hidden_per_blur * rig_.left.fx * motion_.Extent();
    if (!(map_.IsEmpty() ? Begin(*view, record) : Localize(*view, record))) Lose(record);
  } else {
    Lose(record);
  }
  records_.push_back(std::move(record));
  FinishBefore(map_.WindowBegin());
  return records_.back().answer;
}

std::optional<StereoView> StereoVo::Tracker::View(const Observation& observation) {
  if (!IsPair(observation, records_.empty())) return {};
  StereoView view = DetectInBoth(observation, rig_, *detector_, options_.max_features);
  const ImageMotion of_left{motion_.PathsOfRows(readout_ms_), motion_.ReadoutPath(readout_ms_)};
  const ImageMotion of_right = of_left.Of(map_.rig().X_LR);
  UndoMotion(rig_.left, of_left, {}, options_.noise, view.left);
  UndoMotion(rig_.right, of_right, {}, options_.noise, view.right);
  view.partner = MatchStereo(map_.rig(), view.left, view.right, options_.stereo);
  UndoMotionOfNear(of_left, of_right, view);
  view.points_per_error = PointsPerError(view.left.features.keypoints, view.left.covariance_px, options_.noise);
  if (records_.empty()) RefuseSwapped(rig_, view);
  return view;
}

/// Now that depths are known. Partners have much the same one.
void StereoVo::Tracker::UndoMotionOfNear(const ImageMotion& of_left, const ImageMotion& of_right,
                                         StereoView& view) const {
  const std::vector<double> inverse_depths = InverseDepths(map_.rig(), view);
  if ((of_left.exposures.empty() && of_left.readout.empty()) || inverse_depths.empty()) return;
  std::vector<double> right(view.right.size(), 0);
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (view.partner[i] >= 0) right[size_t(view.partner[i])] = inverse_depths[i];
  }
  UndoMotion(rig_.left, of_left, inverse_depths, options_.noise, view.left);
  UndoMotion(rig_.right, of_right, right, options_.noise, view.right);
}

/// The first keyframe of a map, where the last known pose was.
bool StereoVo::Tracker::Begin(const StereoView& view, Record& record) {
  const int pairs = int(std::count_if(view.partner.begin(), view.partner.end(), [](int p) { return p >= 0; }));
  if (pairs < options_.min_inliers) return false;
  map_.AddKeyframe(view, PredictPose(), {}, {});
  NoteKeyframe();
  keyframe_view_ = view;
  policy_.OnKeyframe(pairs);
  record.keyframe = int(map_.keyframes().size()) - 1;
  record.answer.status = TrackingStatus::kTracking;
  record.answer.inliers = pairs;
  record.answer.restarted = record.keyframe > 0;
  const Pose X_WC = map_.keyframes().back();
  record.answer.pose = X_WC;
  SayCovariance(record.unknown_motion, map_.SharedCovariance(record.keyframe), {}, record);
  live_.before = final_.before = {X_WC, {}};
  Remember({record.answer.stamp_ns, X_WC}, 0);
  return true;
}

bool StereoVo::Tracker::Localize(const StereoView& view, Record& record) {
  const auto found = FindPose(view);
  if (!found) return false;
  record.keyframe = int(map_.keyframes().size()) - 1;
  const Pose& X_WC = found->result.X_WC;
  record.X_KC = map_.keyframes().back().Inverse() * X_WC;
  std::vector<int> landmarks;
  for (size_t m = 0; m < found->matches.size(); ++m) {
    landmarks.push_back(found->matches[m].landmark);
    if (found->result.use[m] == SightingUse::kNone) continue;
    RigSighting sighting = map_.SightingOf(view, found->matches[m]);
    sighting.has_right &= found->result.use[m] == SightingUse::kBoth;
    record.sightings.emplace_back(found->matches[m].landmark, sighting);
  }
  record.lens_errors = map_.LensErrorsFrom(record.keyframe, record.sightings, record.X_KC);
  Answer(found->result, landmarks, live_, record);
  Remember({record.answer.stamp_ns, X_WC}, LargestSigma(record.answer.own_covariance->bottomRightCorner<3, 3>()));
  Extend(view, *found);
  return true;
}

/// From the prediction, or from anywhere.
std::optional<StereoVo::Tracker::Localized> StereoVo::Tracker::FindPose(const StereoView& view) {
  const RigPosePrior prior = Prior();
  const double f = rig_.left.fx;
  std::vector<double> radii = {options_.search_px / f, std::numeric_limits<double>::infinity()};
  if (motion_.PredictsPosition()) radii.insert(radii.begin(), options_.predicted_px / f);
  for (const double radius : radii) {
    Localized rough;
    rough.matches = std::isinf(radius) ? map_.SearchAnywhere(view, options_.ratio)
                                       : map_.SearchNear(view, prior.X_WC, radius, options_.ratio);
    const std::vector<RigSighting> sightings = Sightings(view, rough.matches);
    const auto result =
        EstimateRigPose(sightings, map_.rig().X_LR, prior, options_.min_inliers, pose_options_, random_);
    if (!result || !IsBeyondChance(*result, sightings, radius)) continue;
    rough.result = *result;
    if (auto refined = Refined(view, rough, prior)) return refined;
  }
  return {};
}

/// Of matches that lie anywhere within the radius, some fit by chance: as many as a Poisson distribution gives, to
/// three standard deviations, are none.
bool StereoVo::Tracker::IsBeyondChance(const RigPoseResult& result, const std::vector<RigSighting>& sightings,
                                       double radius) const {
  double chance = 0;
  for (const RigSighting& sighting : sightings) {
    const double area = std::pow(options_.outlier_sigmas, 2) * std::sqrt(sighting.covariance_left.determinant());
    chance += std::min(1.0, area / (radius * radius));
  }
  return double(result.inliers) > chance + 3 * std::sqrt(chance);
}

/// Searched again near where the landmarks project from a pose.
std::optional<StereoVo::Tracker::Localized> StereoVo::Tracker::Refined(const StereoView& view, const Localized& rough,
                                                                       const RigPosePrior& prior) const {
  Localized refined;
  const double nearby_ratio = 0.5 + 0.5 * options_.ratio;  // a narrow search leaves few rivals
  refined.matches = map_.SearchNear(view, rough.result.X_WC, options_.narrow_px / rig_.left.fx, nearby_ratio);
  const auto result = RefineRigPose(Sightings(view, refined.matches), map_.rig().X_LR, rough.result.X_WC, prior,
                                    options_.min_inliers, pose_options_);
  if (!result || !Supports(result->covariance_own, prior)) return {};
  refined.result = *result;
  return refined;
}

std::vector<RigSighting> StereoVo::Tracker::Sightings(const StereoView& view,
                                                      const std::vector<StereoMatch>& matches) const {
  std::vector<RigSighting> sightings;
  for (const StereoMatch& match : matches) sightings.push_back(map_.SightingOf(view, match));
  return sightings;
}

Pose StereoVo::Tracker::PredictPose() const {
  if (!last_) return {};
  return motion_.PredictPose();
}

/// As far as a robot's head gets in the time since the last pose, and turned as the gyroscope says.
RigPosePrior StereoVo::Tracker::Prior() const {
  constexpr double kSpeed_mps = 0.5, kLeast = 1e-3;
  const double seconds = last_ ? 1e-9 * double(motion_.stamp_ns() - last_->stamp_ns) : 0;
  return {PredictPose(), kLeast + kSpeed_mps * seconds, kLeast + std::hypot(last_turn_sigma_, motion_.TurnSigma())};
}

SinceKeyframe StereoVo::Tracker::CompareWithKeyframe(const Localized& found) const {
  const Pose& X_WK = map_.keyframes().back();
  const Pose& X_WC = found.result.X_WC;
  std::vector<double> angles;
  for (size_t m = 0; m < found.matches.size(); ++m) {
    if (found.result.use[m] == SightingUse::kNone) continue;
    const Eigen::Vector3d ray = map_.landmarks()[size_t(found.matches[m].landmark)].p_W - X_WC.translation;
    angles.push_back(ray.cross(X_WC.translation - X_WK.translation).norm() / ray.squaredNorm());
  }
  return {rig_.left.fx * UpperMedian(std::move(angles)), RotationAngle(X_WK.rotation, X_WC.rotation),
          found.result.inliers, is_sharp_};
}

void StereoVo::Tracker::Extend(const StereoView& view, const Localized& found) {
  if (policy_.IsKeyframe(motion_.stamp_ns(), CompareWithKeyframe(found))) {
    map_.AddKeyframe(view, found.result.X_WC, found.matches, found.result.use);
    NoteKeyframe();
    keyframe_view_ = view;
    policy_.OnKeyframe(found.result.inliers);
    return;
  }
  std::vector<StereoMatch> inliers;
  for (size_t m = 0; m < found.matches.size(); ++m) {
    if (found.result.use[m] != SightingUse::kNone) inliers.push_back(found.matches[m]);
  }
  map_.Refresh(view, inliers);
}

void StereoVo::Tracker::Remember(const StampedPose& known, double turn_sigma) {
  last_ = known;
  last_turn_sigma_ = turn_sigma;
  motion_.AddPose(known.stamp_ns, known.pose);
  lost_frames_ = 0;
}

void StereoVo::Tracker::Lose(Record& record) {
  record.answer.status = last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  if (last_) record.answer.predicted = PredictPose();
  live_.before.by_landmark.clear();
  if (!map_.IsEmpty() && ++lost_frames_ > options_.max_lost_frames) map_.Clear();
}

/// How the newest keyframe's pose would move with each landmark that it saw.
void StereoVo::Tracker::NoteKeyframe() {
  const int keyframe = int(map_.keyframes().size()) - 1;
  const Pose& X_WK = map_.keyframes().back();
  std::vector<RigSighting> sightings;
  std::vector<int> landmarks;
  for (const auto& [landmark, sighting] : map_.SightingsOf(keyframe)) {
    landmarks.push_back(landmark);
    sightings.push_back(sighting);
  }
  const auto result = RefineRigPose(sightings, map_.rig().X_LR, X_WK, {X_WK, kWide, kWide}, 6, pose_options_);
  LandmarkGains& gains = at_keyframe_[keyframe] = {X_WK, {}};
  for (size_t i = 0; result && i < landmarks.size(); ++i) gains.by_landmark[landmarks[i]] = result->by_point[i];
}

/// Fills a record's answer.
/// @param landmarks of each sighting of `result`
/// @param passed by the frames before; by this one, too, afterwards
void StereoVo::Tracker::Answer(const RigPoseResult& result, const std::vector<int>& landmarks, Passed& passed,
                               Record& record) const {
  LandmarkGains now{result.X_WC, {}};
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (result.use[i] != SightingUse::kNone) now.by_landmark[landmarks[i]] = result.by_point[i];
  }
  // What the model says of the images, and of the landmarks that only one of two frames uses, is the least there is.
  constexpr double kOfTwoFrames = 0.5, kLeastShare = 0.1;
  const Matrix6d modelled =
      result.covariance_own + kOfTwoFrames * DifferenceOfLandmarks(passed.before, now, map_.landmarks());
  const Eigen::Matrix<double, 6, 3> by_rate = ByRate(now);
  const Matrix6d own = record.residuals_share * result.covariance_by_residuals + kLeastShare * modelled +
                       by_rate * record.rate_covariance * by_rate.transpose();
  FrameEstimate& answer = record.answer;
  answer.status = TrackingStatus::kTracking;
  answer.pose = result.X_WC;
  answer.inliers = result.inliers;
  const Pose X_KC = map_.keyframes()[size_t(record.keyframe)].Inverse() * result.X_WC;
  const Matrix6d shared =
      &passed == &live_ ? SharedLive(record.keyframe, now, passed) : SharedFinal(record.keyframe, now, passed);
  SayCovariance(own + record.unknown_motion, shared, X_KC, record);
  passed.before = std::move(now);
}

/// What an error of the rate by which a rolling shutter was undone does to a pose, d tau / d rate in the camera's
/// frame, s: it turns every point about the camera for the time from the stamp to the point's row.
Eigen::Matrix<double, 6, 3> StereoVo::Tracker::ByRate(const LandmarkGains& gains) const {
  Eigen::Matrix<double, 6, 3> by_rate = Eigen::Matrix<double, 6, 3>::Zero();
  const Pose X_CW = gains.X_WC.Inverse();
  for (const auto& [landmark, by_point] : gains.by_landmark) {
    const Eigen::Vector3d p_C = X_CW * map_.landmarks()[size_t(landmark)].p_W;
    const auto pixel = rig_.left.Project(p_C);
    if (!pixel) continue;
    const double seconds = 1e-3 * readout_ms_ * (pixel->y() / std::max(1.0, rig_.left.height_px - 1.0) - 0.5);
    by_rate += seconds * by_point * (gains.X_WC.R() * Hat(p_C));
  }
  return by_rate;
}

/// What the map adds to the error of a pose in it: with the keyframe's, and what landmarks add since then.
Matrix6d StereoVo::Tracker::SharedLive(int keyframe, const LandmarkGains& now, Passed& passed) const {
  const LandmarkGains& at = at_keyframe_.at(keyframe);
  const Pose X_KC = map_.keyframes()[size_t(keyframe)].Inverse() * now.X_WC;
  const Matrix6d since = map_.PointsPerError(keyframe) * DifferenceOfLandmarks(at, now, map_.landmarks());
  passed.grown.Add(now.X_WC, CarryCovariance(map_.SharedCovariance(keyframe), X_KC) + since);
  return passed.grown.covariance();
}

/// The same where it is known what is added until the next keyframe: as much of that as landmarks have added. The first
/// keyframe of another map adds nothing.
Matrix6d StereoVo::Tracker::SharedFinal(int keyframe, const LandmarkGains& now, Passed& passed) const {
  const LandmarkGains& at = at_keyframe_.at(keyframe);
  if (passed.keyframe != keyframe) passed.grown = {};
  passed.keyframe = keyframe;
  passed.grown.Add(now.X_WC, DifferenceOfLandmarks(at, now, map_.landmarks()));
  const Pose X_KC = map_.keyframes()[size_t(keyframe)].Inverse() * now.X_WC;
  const Matrix6d until_keyframe = CarryCovariance(map_.SharedCovariance(keyframe), X_KC);
  const auto next = at_keyframe_.find(keyframe + 1);
  const bool is_known = next != at_keyframe_.end() && !map_.GrownBetween(keyframe, keyframe + 1).isZero(0);
  if (!is_known) return until_keyframe + map_.PointsPerError(keyframe) * passed.grown.covariance();
  const double share = passed.grown.ShareOf(DifferenceOfLandmarks(at, next->second, map_.landmarks()));
  const Pose X_NC = map_.keyframes()[size_t(keyframe) + 1].Inverse() * now.X_WC;
  return until_keyframe + share * CarryCovariance(map_.GrownBetween(keyframe, keyframe + 1), X_NC);
}

/// The frame's own, what it shares with its neighbours, and what the lenses' calibration does to all frames.
void StereoVo::Tracker::SayCovariance(const Matrix6d& own, const Matrix6d& shared, const Pose& X_KC,
                                      Record& record) const {
  FrameEstimate& answer = record.answer;
  answer.own_covariance = own;
  answer.covariance = own + shared;
  if (lens_.IsExact()) return;
  answer.common_errors = ChainLensErrors(map_.LensErrorsBetween(0, record.keyframe), X_KC, record.lens_errors);
  *answer.covariance += answer.common_errors * answer.common_errors.transpose();
}

/// Frames whose keyframe can move no more get their final pose; what they saw is no longer needed.
void StereoVo::Tracker::FinishBefore(int keyframe) {
  for (; finished_ < records_.size() && records_[finished_].keyframe < keyframe; ++finished_) {
    FinishRecord(records_[finished_]);
  }
  at_keyframe_.erase(at_keyframe_.begin(), at_keyframe_.lower_bound(keyframe));
}

void StereoVo::Tracker::FinishRecord(Record& record) {
  if (record.keyframe < 0) {
    final_.before.by_landmark.clear();
    return;
  }
  std::vector<RigSighting> sightings;
  std::vector<int> landmarks;
  for (auto& [landmark, sighting] : record.sightings) {
    sighting.p_W = map_.landmarks()[size_t(landmark)].p_W;
    sighting.covariance_W = map_.landmarks()[size_t(landmark)].covariance_W;
    sightings.push_back(sighting);
    landmarks.push_back(landmark);
  }
  const Pose guess = map_.keyframes()[size_t(record.keyframe)] * record.X_KC;
  const RigPosePrior prior{guess, kWide, kWide};
  const auto result = RefineRigPose(sightings, map_.rig().X_LR, guess, prior, options_.min_inliers, pose_options_);
  if (result && Supports(result->covariance_own, prior)) {
    Answer(*result, landmarks, final_, record);
  } else {
    record.answer.pose = guess;
    final_.before = {guess, {}};
  }
  record.sightings = {};
}

std::vector<FrameEstimate> StereoVo::Tracker::Finish() {
  FinishBefore(int(map_.keyframes().size()));
  std::vector<FrameEstimate> frames;
  for (const Record& record : records_) frames.push_back(record.answer);
  return frames;
}

StereoVo::StereoVo(const Calibration& calibration, const StereoVoOptions& options, uint64_t seed) {
  CheckFields(options, "stereo_vo.");
  StereoRig::Of(calibration).Check();
  tracker_ = std::make_unique<Tracker>(calibration, options, seed);
}

StereoVo::~StereoVo() = default;

FrameEstimate StereoVo::Track(const Observation& observation) { return tracker_->Track(observation); }

std::vector<FrameEstimate> StereoVo::Finish() { return tracker_->Finish(); }

Pose StereoVo::X_LR() const { return tracker_->X_LR(); }

const StereoMap& StereoVo::map() const { return tracker_->map(); }

const StereoView* StereoVo::keyframe_view() const { return tracker_->keyframe_view(); }

}  // namespace gaitcam
