#include "algorithms/odometry/mobif_vo_plus.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "algorithms/core/random.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/absolute_pose.h"
#include "algorithms/geometry/homography.h"
#include "algorithms/geometry/two_view.h"
#include "algorithms/odometry/floor_guess.h"
#include "algorithms/odometry/landmark_map.h"
#include "algorithms/odometry/landmark_search.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kLevel = 0.82;  // cosine of the largest angle between a floor's normal and the camera's up: 35 degrees

double Median(std::vector<double> values) {
  GAITCAM_ASSERT(!values.empty());
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Where a frame stands: its place relative to a keyframe, so that what is learnt of the keyframe later moves it too.
struct FrameRecord {
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

LandmarkMapOptions MapOptions(const MobifVoPlusOptions& o) {
  return {o.window, o.memory, o.adjust_iterations, o.outlier_sigmas};
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
        map_(MapOptions(options)) {}

  FrameEstimate Track(const Observation& observation);
  std::vector<FrameEstimate> Finish();

 private:
  FrameView Look(const cv::Mat& image) const;
  RansacOptions Ransacking(double noise) const { return {3.0 * noise / camera_.fx, 0.999, 100, 5}; }

  bool Start(FrameView& view);
  void PlaceWaiting();
  bool StartMap(FrameView& view, const std::vector<Match>& matches, const TwoView& two_view);
  void AddKeyframe(FrameView& view);
  LandmarkMap::Guess Guess() const {
    return [this](const Pose& X_WC, const Eigen::Vector2d& xy) { return floor_.At(X_WC, xy); };
  }
  Pose Predict(const Observation& observation) const;
  bool Locate(FrameView& view, const Pose& prediction);
  bool LocateWithNoise(FrameView& view, const Pose& prediction, double noise);
  bool Agree(FrameView& view, const std::vector<LandmarkMatch>& matches, const Pose& guess, double noise);
  bool AgreeNearby(FrameView& view, const std::vector<LandmarkMatch>& matches, const Pose& guess, double noise,
                   double radius);
  bool LookClosely(FrameView& view, const Pose& prediction, double noise);
  LandmarkSearchOptions SearchOptions(double radius, double ratio) const;
  bool Settle(FrameView& view, const std::vector<LandmarkMatch>& matches,
              const std::vector<InverseDepthSighting>& sightings, Pose pose);
  std::vector<InverseDepthSighting> Sightings(const FrameView& view, const std::vector<LandmarkMatch>& matches,
                                              double noise) const;
  PositionPrior Expect(const Pose& near, int64_t apart_ns) const;
  void PlaceMissed(const FrameView& view, int64_t stamp_ns);
  bool WantsKeyframe(const FrameView& view);
  bool IsKeyframeDue(const FrameView& view) const;
  void ScaleNoise(FrameView& view) const;
  void Record(const FrameEstimate& answer, const FrameView& view);

  Calibration calibration_;
  CameraModel camera_;
  MobifVoPlusOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;

  LandmarkMap map_;
  FloorGuess floor_;
  std::optional<FrameView> reference_;  ///< The first of the two frames that will start a map.
  struct Waiting {
    size_t record = 0;
    FrameView view;
    int64_t stamp_ns = 0;
  };
  std::vector<Waiting> waiting_;        ///< Frames since then, for the map to place once there is one.
  std::vector<Waiting> missed_;         ///< Frames without a pose since the last one that has one.
  std::optional<PositionPrior> prior_;  ///< Of the frame that is being located.
  int fewest_inliers_ = 0;              ///< Likewise.
  std::vector<LandmarkMatch> inliers_;  ///< Of the present frame.
  int keyframe_ = -1;                   ///< The latest of the present map; -1: there is no map yet.
  int keyframe_inliers_ = 0;            ///< Most landmarks that a frame since the last keyframe saw.
  double usual_inliers_ = 0;            ///< Landmarks seen per frame, lately.
  int waiting_frames_ = 0;              ///< Since a keyframe was due.
  std::optional<Pose> X_WC_last_;       ///< Last known pose, over all maps.
  int64_t last_ns_ = 0;                 ///< Its stamp.
  double median_depth_ = 1;             ///< At the last keyframe; the unit when a map begins.
  int lost_frames_ = 0;
  std::vector<FrameRecord> records_;
};

FrameEstimate MobifVoPlus::Tracker::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = Look(observation.image.pixels);
  answer.features = view.features.size();
  inliers_.clear();
  const bool had_map = keyframe_ >= 0, was_lost = lost_frames_ > options_.max_lost_frames;
  prior_.reset();
  fewest_inliers_ = options_.min_inliers;
  if (had_map) prior_ = Expect(*X_WC_last_, answer.stamp_ns - last_ns_);
  const bool found = had_map ? Locate(view, Predict(observation)) : Start(view);
  answer.inliers = int(inliers_.size());
  if (found) {
    answer.status = TrackingStatus::kTracking;
    answer.restarted = was_lost;
    lost_frames_ = 0;
    if (had_map && WantsKeyframe(view)) {
      ScaleNoise(view);
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

FrameView MobifVoPlus::Tracker::Look(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  FrameView view;
  view.features = DetectFeatures(*detector_, image, options_.max_features);
  for (const cv::KeyPoint& keypoint : view.features.keypoints) {
    view.xy.push_back(camera_.Unproject({keypoint.pt.x, keypoint.pt.y}).head<2>());
    view.sigma.push_back((options_.sigma_px + options_.sigma_per_size * keypoint.size) / camera_.fx);
  }
  return view;
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
  const double unit = median_depth_ / Median(depths);
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
    if (!LocateWithNoise(frame.view, reference_->X_WC, 1)) continue;
    records_[frame.record].keyframe = keyframe_;
    records_[frame.record].X_KC = map_.keyframes()[size_t(keyframe_)].Inverse() * frame.view.X_WC;
  }
  waiting_.clear();
}

void MobifVoPlus::Tracker::AddKeyframe(FrameView& view) {
  keyframe_ = map_.AddKeyframe(view, inliers_, median_depth_, Guess());
  keyframe_inliers_ = 0;
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

/// With a map: the pose from its landmarks. A frame that is blurred more than its features can tell places them badly:
/// where nothing agrees, a second look expects more noise.
bool MobifVoPlus::Tracker::Locate(FrameView& view, const Pose& prediction) {
  for (const double noise : {1.0, options_.noise_of_second_look}) {
    if (LocateWithNoise(view, prediction, noise)) {
      keyframe_inliers_ = std::max(keyframe_inliers_, int(inliers_.size()));
      return true;
    }
  }
  return false;
}

LandmarkSearchOptions MobifVoPlus::Tracker::SearchOptions(double radius, double ratio) const {
  LandmarkSearchOptions search;
  search.radius = radius;
  search.ratio = ratio;
  search.same_place = 2 / camera_.fx;
  return search;
}

/// Looks for landmarks where they should be, else anywhere; then once more, closely, from the pose found.
bool MobifVoPlus::Tracker::LocateWithNoise(FrameView& view, const Pose& prediction, double noise) {
  const LandmarkSearchOptions wide = SearchOptions(options_.search_deg * kRadPerDeg, options_.ratio);
  if (!Agree(view, SearchNear(map_, view, prediction, wide), prediction, noise) &&
      !Agree(view, SearchAnywhere(map_, view, options_.ratio), prediction, noise)) {
    return false;
  }
  // Nearness has already told most rivals apart.
  const LandmarkSearchOptions close = SearchOptions(5 * noise / camera_.fx, 0.5 + 0.5 * options_.ratio);
  const Pose found = view.X_WC;
  return Agree(view, SearchNear(map_, view, found, close), found, noise);
}

/// What moved fast looks like nothing else for certain: less distinct matches will do, if they are near enough.
bool MobifVoPlus::Tracker::LookClosely(FrameView& view, const Pose& prediction, double noise) {
  constexpr double kCloser = 0.4;  // part of the usual radius
  const double radius = kCloser * options_.search_deg * kRadPerDeg, ratio = 0.5 + 0.5 * options_.ratio;
  if (!AgreeNearby(view, SearchNear(map_, view, prediction, SearchOptions(radius, ratio)), prediction, noise, radius)) {
    return false;
  }
  const Pose found = view.X_WC;
  const LandmarkSearchOptions close = SearchOptions(5 * noise / camera_.fx, ratio);
  return Agree(view, SearchNear(map_, view, found, close), found, noise);
}

std::vector<InverseDepthSighting> MobifVoPlus::Tracker::Sightings(const FrameView& view,
                                                                  const std::vector<LandmarkMatch>& matches,
                                                                  double noise) const {
  std::vector<InverseDepthSighting> sightings;
  for (const LandmarkMatch& match : matches) {
    const size_t i = size_t(match.feature);
    sightings.push_back({map_.Point(map_.landmarks()[size_t(match.landmark)]), view.xy[i], noise * view.sigma[i]});
  }
  return sightings;
}

/// The pose that most matches agree upon, and those matches as `inliers_`. Far from where the camera is expected chance
/// agrees upon something too, on a floor of a thousand like pebbles above all: there it takes as many as usual.
bool MobifVoPlus::Tracker::Agree(FrameView& view, const std::vector<LandmarkMatch>& matches, const Pose& guess,
                                 double noise) {
  if (prior_ && AgreeNearby(view, matches, guess, noise, options_.search_deg * kRadPerDeg)) return true;
  inliers_.clear();
  std::vector<PointSighting> known, any;
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = map_.landmarks()[size_t(match.landmark)];
    if (landmark.rho <= 0) continue;
    (landmark.Known() ? known : any).push_back({map_.Place(landmark), view.xy[size_t(match.feature)]});
  }
  // After a turn on the spot hardly anything in view has a known depth: then all have to do.
  if (int(known.size()) < 4 * options_.min_inliers) known.insert(known.end(), any.begin(), any.end());
  const auto rough = EstimateAbsolutePose(known, Ransacking(noise), random_, guess);
  if (int(rough.inliers.size()) < options_.min_inliers) return false;
  const std::optional<PositionPrior> prior = std::exchange(prior_, {});
  const bool settled = Settle(view, matches, Sightings(view, matches, noise), rough.model);
  prior_ = prior;
  constexpr double kManyAsUsual = 0.5;
  return settled && (!prior_ || double(inliers_.size()) > kManyAsUsual * usual_inliers_);
}

/// Where the camera is expected, a turn alone has to be found: the one that many more agree upon than would by chance.
bool MobifVoPlus::Tracker::AgreeNearby(FrameView& view, const std::vector<LandmarkMatch>& matches, const Pose& guess,
                                       double noise, double radius) {
  const std::vector<InverseDepthSighting> sightings = Sightings(view, matches, noise);
  const TurnResult turn = EstimateTurn(sightings, *prior_, guess.rotation, M_PI * radius * radius, random_);
  constexpr double kSurprise = 4;  // standard deviations; many turns are tried
  const double enough = std::max(double(fewest_inliers_), turn.chance + kSurprise * std::sqrt(turn.chance));
  if (double(turn.inliers.size()) < enough) return false;
  if (!Settle(view, matches, sightings, RefinePose(sightings, turn.inliers, turn.X_WC, 2, prior_))) return false;
  constexpr double kTooFar = 4;
  return (view.X_WC.translation - prior_->position_W).norm() < kTooFar * prior_->sigma;
}

/// Refines a pose by all that agree with it.
bool MobifVoPlus::Tracker::Settle(FrameView& view, const std::vector<LandmarkMatch>& matches,
                                  const std::vector<InverseDepthSighting>& sightings, Pose pose) {
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  std::vector<int> inliers;
  constexpr int kRounds = 3;  // each refinement lets in what agrees with it
  for (int round = 0; round < kRounds; ++round) {
    inliers.clear();
    for (int i = 0; i < int(sightings.size()); ++i) {
      if (Mahalanobis2(sightings[size_t(i)], pose) < limit2) inliers.push_back(i);
    }
    if (int(inliers.size()) < fewest_inliers_) return false;
    pose = RefinePose(sightings, inliers, pose, 2, prior_);
  }
  view.X_WC = pose;
  inliers_.clear();
  for (const int i : inliers) inliers_.push_back(matches[size_t(i)]);
  return true;
}

/// A walker's camera is about where it was.
PositionPrior MobifVoPlus::Tracker::Expect(const Pose& near, int64_t apart_ns) const {
  return {near.translation, options_.usual_speed * median_depth_ * double(apart_ns) * 1e-9};
}

/// Frames that were lost between two that have a pose have better expectations now: for the final word.
void MobifVoPlus::Tracker::PlaceMissed(const FrameView& view, int64_t stamp_ns) {
  for (Waiting& frame : missed_) {
    const double part = double(frame.stamp_ns - last_ns_) / double(stamp_ns - last_ns_);
    const Pose guess(X_WC_last_->rotation.slerp(part, view.X_WC.rotation),
                     (1 - part) * X_WC_last_->translation + part * view.X_WC.translation);
    constexpr double kBetween = 0.5;  // one neighbour would leave so much more open than two
    prior_ = Expect(guess, std::min(frame.stamp_ns - last_ns_, stamp_ns - frame.stamp_ns));
    prior_->sigma *= kBetween;
    fewest_inliers_ = (options_.min_inliers + 1) / 2;
    constexpr double kNoiseOfBlur = 1.5;
    if (!Locate(frame.view, guess) && !LookClosely(frame.view, guess, kNoiseOfBlur)) continue;
    records_[frame.record].keyframe = keyframe_;
    records_[frame.record].X_KC = map_.keyframes()[size_t(keyframe_)].Inverse() * frame.view.X_WC;
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
  const bool in_danger = usual_inliers_<2 * options_.min_inliers, is_late = waiting_frames_> options_.max_wait_frames;
  constexpr double kGoodEnough = 0.7;  // part of the usual, once it is late
  const double enough = is_late ? kGoodEnough * usual_inliers_ : usual_inliers_;
  if (inliers < enough && !in_danger && waiting_frames_ <= 2 * options_.max_wait_frames) return false;
  waiting_frames_ = 0;
  return true;
}

/// A blurred frame places its features worse than a sharp one: its own residuals say by how much.
void MobifVoPlus::Tracker::ScaleNoise(FrameView& view) const {
  std::vector<double> distances;
  for (const LandmarkMatch& match : inliers_) {
    const size_t i = size_t(match.feature);
    const InverseDepthPoint point = map_.Point(map_.landmarks()[size_t(match.landmark)]);
    distances.push_back(std::sqrt(Mahalanobis2({point, view.xy[i], view.sigma[i]}, view.X_WC)));
  }
  constexpr double kMedianOfRayleigh = 1.1774;  // of the length of a vector of two unit normals
  const double factor = std::clamp(Median(distances) / kMedianOfRayleigh, 0.5, 3.0);
  for (double& sigma : view.sigma) sigma *= factor;
}

bool MobifVoPlus::Tracker::IsKeyframeDue(const FrameView& view) const {
  if (usual_inliers_ < options_.keyframe_overlap * keyframe_inliers_) return true;
  const Pose& X_WK = map_.keyframes()[size_t(keyframe_)];
  if (RotationAngle(X_WK.rotation, view.X_WC.rotation) > options_.keyframe_turn_deg * kRadPerDeg) return true;
  const Eigen::Vector3d baseline = view.X_WC.translation - X_WK.translation;
  std::vector<double> angles;
  for (const LandmarkMatch& match : inliers_) {
    const Landmark& landmark = map_.landmarks()[size_t(match.landmark)];
    const Eigen::Vector3d ray = map_.keyframes()[size_t(landmark.anchor)].rotation * landmark.ray.homogeneous();
    angles.push_back(landmark.rho * ray.normalized().cross(baseline).norm() / landmark.ray.homogeneous().norm());
  }
  return Median(angles) > options_.keyframe_parallax_deg * kRadPerDeg;
}

void MobifVoPlus::Tracker::Record(const FrameEstimate& answer, const FrameView& view) {
  FrameRecord record{answer, -1, Pose()};
  if (answer.pose && keyframe_ >= 0) {
    record.keyframe = keyframe_;
    record.X_KC = map_.keyframes()[size_t(keyframe_)].Inverse() * view.X_WC;
  }
  records_.push_back(record);
}

/// Frames after a keyframe move with it.
std::vector<FrameEstimate> MobifVoPlus::Tracker::Finish() {
  std::vector<FrameEstimate> frames;
  for (const FrameRecord& record : records_) {
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
