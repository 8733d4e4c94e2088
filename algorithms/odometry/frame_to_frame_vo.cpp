#include "algorithms/odometry/frame_to_frame_vo.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "algorithms/core/random.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"
#include "algorithms/geometry/triangulation.h"
#include "algorithms/geometry/two_view.h"
#include "algorithms/odometry/landmark_map.h"
#include "algorithms/odometry/landmark_pose.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kFlat = 5;  // times the parallax is asked of a start that looks like a plane

double Median(std::vector<double> values) {
  GAITCAM_ASSERT(!values.empty());
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// What the steps of a pair have placed is not moved any more.
LandmarkMapOptions MapOptions(const FrameToFrameVoOptions& o) {
  LandmarkMapOptions options;
  options.window = o.placing == "two_view" ? 0 : o.window;
  options.adjust_iterations = 10;
  options.memory = o.memory;
  return options;
}

/// Where a frame stands: relative to a chosen one, so that what is learnt of that one later moves it too.
struct FrameRecord {
  FrameEstimate answer;
  int chosen = -1;
  Pose X_KC;
};

/// Nothing is known of a place before it is seen twice.
std::optional<DepthGuess> NoGuess(const Pose&, const Eigen::Vector2d&) { return {}; }

}  // namespace

class FrameToFrameVo::Tracker {
 public:
  Tracker(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed)
      : camera_(camera),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "frame_to_frame_vo"),
        threshold_(options.threshold_px / camera.fx),
        map_(MapOptions(options)) {}

  FrameEstimate Track(const Observation& observation) {
    const FrameEstimate answer = Answer(observation);
    records_.push_back({answer, -1, Pose()});
    if (answer.pose) Attach(records_.back(), *answer.pose);
    if (has_points_ && !waiting_.empty()) PlaceWaiting();
    return answer;
  }
  std::vector<FrameEstimate> Finish() const;

 private:
  FrameEstimate Answer(const Observation& observation);
  FrameView Look(const cv::Mat& image) const;
  std::vector<Match> MatchWithChosen(const FrameView& view) const;
  std::vector<PointPair> PairsOf(const FrameView& view, const std::vector<Match>& matches) const;
  RansacOptions Robustly() const;
  LandmarkPoseOptions ByPoints() const;

  bool Start(FrameView& view);
  bool BeginReconstruction(FrameView& view, const std::vector<Match>& matches, const TwoView& two_view);
  void PlaceWaiting();
  void Attach(FrameRecord& record, const Pose& X_WC) const;
  bool Follow(FrameView& view);
  bool PlaceByPoints(FrameView& view);
  bool PlaceByTwoViews(FrameView& view);
  std::optional<double> ScaleFromCommonPoints(const FrameView& view, const std::vector<Match>& matches,
                                              const TwoView& two_view);
  TwoView Reconstruct(const std::vector<PointPair>& pairs);
  bool IsPairDue(const FrameView& view) const;
  bool MakesAPair(const FrameView& view);
  void Choose(FrameView view);
  std::vector<std::optional<double>> DepthsOfPair(const FrameView& view) const;
  std::optional<double> Depth(const Pose& X_AB, const PointPair& pair) const;
  void GiveUp();

  CameraModel camera_;
  FrameToFrameVoOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;
  double threshold_;  ///< Normalised coordinates.

  std::optional<FrameView> chosen_;            ///< The last chosen frame: first view of the next pair.
  std::vector<std::optional<double>> depths_;  ///< two_view: of its features, as the last pair has them.
  LandmarkMap map_;                            ///< The points that the latest chosen frames saw.
  bool has_points_ = false;                    ///< false: no reconstruction yet.
  std::vector<LandmarkMatch> inliers_;         ///< That agree with the present pose.
  int most_inliers_ = 0;                       ///< Of a frame since the last chosen one.
  double usual_inliers_ = 0;                   ///< Per frame, lately.
  int waiting_frames_ = 0;                     ///< Since a pair was due.

  std::optional<Pose> X_WC_last_;  ///< Last known pose, over all restarts.
  double median_depth_ = 1;        ///< In the last chosen frame; the unit when a path begins.
  int lost_frames_ = 0;
  int start_frames_ = 0;  ///< Frames since there was a reconstruction, or since the first.
  int start_misses_ = 0;  ///< Of these the latest that could not be matched with the chosen one.
  struct Waiting {
    size_t record = 0;
    FrameView view;
  };
  std::vector<Waiting> waiting_;  ///< Frames for the reconstruction to place once there is one.
  std::vector<FrameRecord> records_;
};

FrameEstimate FrameToFrameVo::Tracker::Answer(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = Look(observation.image.pixels);
  answer.features = view.features.size();
  inliers_.clear();
  const bool had_points = has_points_;
  const bool found = had_points ? Follow(view) : Start(view);
  answer.inliers = int(inliers_.size());
  if (!found) {
    constexpr size_t kMostWaiting = 60;  // frames: their features take memory
    if (!had_points && waiting_.size() < kMostWaiting) waiting_.push_back({records_.size(), std::move(view)});
    answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (had_points && ++lost_frames_ > options_.max_lost_frames) GiveUp();
    return answer;
  }
  lost_frames_ = 0;
  answer.status = TrackingStatus::kTracking;
  answer.pose = view.X_WC;
  answer.restarted = !had_points && X_WC_last_.has_value();
  X_WC_last_ = view.X_WC;
  if (!had_points) return answer;
  if (MakesAPair(view)) {
    Choose(std::move(view));
  } else {
    map_.Refresh(view, inliers_);
  }
  return answer;
}

/// Step 1.
FrameView FrameToFrameVo::Tracker::Look(const cv::Mat& image) const {
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

/// Step 2.
std::vector<Match> FrameToFrameVo::Tracker::MatchWithChosen(const FrameView& view) const {
  if (!chosen_) return {};
  return MatchDescriptors(chosen_->features.descriptors, view.features.descriptors, options_.matching);
}

std::vector<PointPair> FrameToFrameVo::Tracker::PairsOf(const FrameView& view,
                                                        const std::vector<Match>& matches) const {
  std::vector<PointPair> pairs;
  for (const Match& match : matches) pairs.push_back({chosen_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
  return pairs;
}

RansacOptions FrameToFrameVo::Tracker::Robustly() const {
  RansacOptions robustly{threshold_, options_.ransac_confidence, options_.ransac_iterations};
  robustly.estimator = options_.estimator;
  robustly.outlier_span = camera_.width_px / camera_.fx;  // a mismatch may lie anywhere in the image
  return robustly;
}

LandmarkPoseOptions FrameToFrameVo::Tracker::ByPoints() const {
  LandmarkPoseOptions options;
  options.search.radius = options_.search_deg * kRadPerDeg;
  options.search.ratio = options_.matching.ratio;
  options.search.same_place = 2 / camera_.fx;  // px
  options.threshold = 1.5 * threshold_;        // the points have their own error
  options.min_inliers = options_.min_matches;
  options.confidence = options_.ransac_confidence;
  options.iterations = options_.ransac_iterations;
  return options;
}

/// Steps 3 to 5: hypotheses from five pairs, the best by distances from epipolar lines, the decomposition with most
/// points in front.
TwoView FrameToFrameVo::Tracker::Reconstruct(const std::vector<PointPair>& pairs) {
  const auto found = EstimateEssential(pairs, Robustly(), random_, EpipolarDistance2);
  if (int(found.inliers.size()) < options_.min_matches) return {};
  if (options_.refine) return RefineTwoView(pairs, found.model, found.inliers, threshold_);
  const RelativeMotion motion = ChooseByDepth(found.model, pairs, found.inliers);
  return DescribeTwoView(pairs, motion, threshold_);
}

/// Without a reconstruction: waits until the camera has moved enough since the chosen frame to see parallax. A few
/// frames that cannot be matched (blurred, covered) do not matter.
bool FrameToFrameVo::Tracker::Start(FrameView& view) {
  const std::vector<Match> matches = MatchWithChosen(view);
  ++start_frames_;
  TwoView two_view;
  if (int(matches.size()) >= options_.min_start_points) two_view = Reconstruct(PairsOf(view, matches));
  if (int(two_view.inliers.size()) < options_.min_start_points) {
    if (chosen_ && ++start_misses_ <= options_.max_start_misses) return false;
    chosen_.reset();
    start_misses_ = 0;
    if (view.features.size() >= options_.min_start_points) chosen_ = view;
    waiting_.clear();
    return false;
  }
  start_misses_ = 0;
  // It only turned, or hardly moved: whatever was computed means nothing yet.
  if (two_view.rotation_only || two_view.alternative) return false;
  // With little parallax everything looks flat; what still does with more of it is flat.
  const double needed_deg = options_.start_parallax_deg * (two_view.planar ? kFlat : 1);
  if (two_view.parallax < needed_deg * kRadPerDeg) return false;
  // Where everything is blurred no baseline is ever certain: less and less is asked for.
  const double patience = 1 + double(start_frames_) / options_.start_patience_frames;
  if (two_view.direction_sigma > patience * options_.start_direction_deg * kRadPerDeg) return false;
  if (!BeginReconstruction(view, matches, two_view)) return false;
  start_frames_ = 0;
  return true;
}

/// The two frames' common points; the unit is such that their median depth is that of the path before (1 at first).
bool FrameToFrameVo::Tracker::BeginReconstruction(FrameView& view, const std::vector<Match>& matches,
                                                  const TwoView& two_view) {
  std::vector<LandmarkMatch> pairs;
  std::vector<std::optional<double>> depths;
  std::vector<double> known;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    depths.push_back(Depth(two_view.X_AB, {chosen_->xy[size_t(match.a)], view.xy[size_t(match.b)]}));
    if (depths.back()) known.push_back(*depths.back());
    pairs.push_back({match.a, match.b});
  }
  if (int(known.size()) < options_.min_start_points) return false;
  const double unit = median_depth_ / Median(known);
  chosen_->X_WC = X_WC_last_.value_or(Pose());
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, unit * two_view.X_AB.translation);
  map_.AddKeyframe(*chosen_, {}, median_depth_, NoGuess);  // its features are the map's landmarks now, in order
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (depths[i]) map_.SetDepth(pairs[i].landmark, 1 / (unit * *depths[i]));
  }
  inliers_ = pairs;
  has_points_ = true;
  Choose(view);
  return true;
}

/// For the final word, from the latest back to the first. A new path is marked where it now begins.
void FrameToFrameVo::Tracker::PlaceWaiting() {
  Pose prediction = *X_WC_last_;
  size_t begin = records_.size() - 1;
  for (auto frame = waiting_.rbegin(); frame != waiting_.rend(); ++frame) {
    const auto placed = PlaceByLandmarks(map_, frame->view, prediction, 1, ByPoints(), random_);
    if (!placed) continue;
    prediction = placed->X_WC;
    begin = frame->record;
    records_[begin].answer.status = TrackingStatus::kTracking;
    records_[begin].answer.inliers = int(placed->inliers.size());
    Attach(records_[begin], placed->X_WC);
  }
  std::swap(records_[begin].answer.restarted, records_.back().answer.restarted);
  waiting_.clear();
}

void FrameToFrameVo::Tracker::Attach(FrameRecord& record, const Pose& X_WC) const {
  record.answer.pose = X_WC;
  record.chosen = int(map_.keyframes().size()) - 1;
  record.X_KC = map_.keyframes().back().Inverse() * X_WC;
}

std::vector<FrameEstimate> FrameToFrameVo::Tracker::Finish() const {
  std::vector<FrameEstimate> frames;
  for (const FrameRecord& record : records_) {
    frames.push_back(record.answer);
    if (record.chosen >= 0) frames.back().pose = map_.keyframes()[size_t(record.chosen)] * record.X_KC;
  }
  return frames;
}

/// With a reconstruction: the pose from its points and, where the frame makes a pair, from the two views.
bool FrameToFrameVo::Tracker::Follow(FrameView& view) {
  const bool placed = PlaceByPoints(view);
  if (options_.placing == "points" || (placed && !IsPairDue(view))) return placed;
  return PlaceByTwoViews(view) || placed;
}

/// A frame that is blurred more than its features can tell places them badly: where nothing agrees, a second look
/// expects more noise.
bool FrameToFrameVo::Tracker::PlaceByPoints(FrameView& view) {
  for (const double noise : {1.0, options_.blurred_noise}) {
    const auto placed = PlaceByLandmarks(map_, view, X_WC_last_.value_or(Pose()), noise, ByPoints(), random_);
    if (!placed) continue;
    view.X_WC = placed->X_WC;
    inliers_ = placed->inliers;
    return true;
  }
  return false;
}

/// Steps 3 to 6 between the last chosen frame and this one. Leaves `view` alone where the two views do not tell.
bool FrameToFrameVo::Tracker::PlaceByTwoViews(FrameView& view) {
  const std::vector<Match> matches = MatchWithChosen(view);
  if (int(matches.size()) < options_.min_matches) return false;
  const TwoView two_view = Reconstruct(PairsOf(view, matches));
  if (two_view.inliers.empty() || two_view.rotation_only || two_view.alternative) return false;
  if (two_view.direction_sigma > options_.max_direction_deg * kRadPerDeg) return false;
  const std::optional<double> scale = ScaleFromCommonPoints(view, matches, two_view);
  if (!scale) return false;
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, *scale * two_view.X_AB.translation);
  inliers_ = FindLandmarks(map_, view, ByPoints());
  return true;
}

/// Step 6: RANSAC on the ratios of depths in the chosen frame, of the pair before over that of this pair.
std::optional<double> FrameToFrameVo::Tracker::ScaleFromCommonPoints(const FrameView& view,
                                                                     const std::vector<Match>& matches,
                                                                     const TwoView& two_view) {
  std::vector<double> log_ratios;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    const std::optional<double> before = depths_[size_t(match.a)];
    const auto depth = Depth(two_view.X_AB, {chosen_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
    if (before && depth) log_ratios.push_back(std::log(*before / *depth));
  }
  RansacOptions robustly = Robustly();
  robustly.threshold = options_.scale_tolerance;
  const auto solve = [&](const std::vector<int>& one) { return std::vector<double>{log_ratios[size_t(one[0])]}; };
  const auto error2 = [&](double log_scale, int i) { return std::pow(log_ratios[size_t(i)] - log_scale, 2); };
  const auto found = Ransac<double>(int(log_ratios.size()), 1, robustly, random_, solve, error2);
  if (int(found.inliers.size()) < options_.min_matches) return std::nullopt;
  double mean = 0;
  for (const int i : found.inliers) mean += log_ratios[size_t(i)] / double(found.inliers.size());
  return std::exp(mean);
}

/// A pair is due once the points have moved, the camera has turned, or points are out of sight.
bool FrameToFrameVo::Tracker::IsPairDue(const FrameView& view) const {
  if (options_.pair_displacement_px == 0) return true;
  if (usual_inliers_ < options_.pair_overlap * most_inliers_) return true;
  if (RotationAngle(chosen_->X_WC.rotation, view.X_WC.rotation) > options_.pair_turn_deg * kRadPerDeg) return true;
  const Eigen::Vector3d baseline = view.X_WC.translation - chosen_->X_WC.translation;
  std::vector<double> angles;
  for (const LandmarkMatch& match : inliers_) {
    const Landmark& landmark = map_.landmarks()[size_t(match.landmark)];
    const Eigen::Vector3d ray = map_.keyframes()[size_t(landmark.anchor)].rotation * landmark.ray.homogeneous();
    angles.push_back(landmark.rho * ray.normalized().cross(baseline).norm() / landmark.ray.homogeneous().norm());
  }
  return angles.empty() || Median(angles) * camera_.fx > options_.pair_displacement_px;
}

/// A pair that is due is made with the next frame that sees at least as many points as usual: one in the middle of a
/// jerk would place all new points badly and see few of the old ones.
bool FrameToFrameVo::Tracker::MakesAPair(const FrameView& view) {
  const double inliers = double(inliers_.size());
  constexpr double kForgetting = 0.1;
  usual_inliers_ = usual_inliers_ > 0 ? (1 - kForgetting) * usual_inliers_ + kForgetting * inliers : inliers;
  most_inliers_ = std::max(most_inliers_, int(inliers_.size()));
  if (options_.pair_displacement_px == 0) return true;
  if (waiting_frames_ == 0 && !IsPairDue(view)) return false;
  ++waiting_frames_;
  const bool in_danger = inliers < 2 * options_.min_matches;
  return inliers >= usual_inliers_ || in_danger || waiting_frames_ > options_.max_wait_frames;
}

/// Points that `view` sees gain a ray, which places them or sharpens their place; all else that it sees may become one.
void FrameToFrameVo::Tracker::Choose(FrameView view) {
  if (!inliers_.empty()) {
    const double factor = std::clamp(NoiseFactor(map_, view, inliers_), 0.5, 3.0);
    for (double& sigma : view.sigma) sigma *= factor;
  }
  map_.AddKeyframe(view, inliers_, median_depth_, NoGuess);
  median_depth_ = map_.MedianDepth(view.X_WC, median_depth_);
  if (options_.placing == "two_view") depths_ = DepthsOfPair(view);
  chosen_ = std::move(view);
  most_inliers_ = waiting_frames_ = 0;
  usual_inliers_ = 0;
}

/// What the pair of the chosen frame and `view` makes of the depths in `view`.
std::vector<std::optional<double>> FrameToFrameVo::Tracker::DepthsOfPair(const FrameView& view) const {
  std::vector<std::optional<double>> depths(view.xy.size());
  const Pose X_BA = view.X_WC.Inverse() * chosen_->X_WC;
  for (const Match& match : MatchWithChosen(view)) {
    depths[size_t(match.b)] = Depth(X_BA, {view.xy[size_t(match.b)], chosen_->xy[size_t(match.a)]});
  }
  return depths;
}

/// In camera A, if the two rays meet at an angle and agree.
std::optional<double> FrameToFrameVo::Tracker::Depth(const Pose& X_AB, const PointPair& pair) const {
  const std::vector<RayObservation> rays = {{Pose(), pair.a}, {X_AB, pair.b}};
  const auto p_A = TriangulatePoint(rays);
  if (!p_A || ParallaxAngle(*p_A, rays) < options_.min_parallax_deg * kRadPerDeg) return {};
  for (const RayObservation& ray : rays) {
    if (ReprojectionError(*p_A, ray) > threshold_) return {};
  }
  return p_A->z();
}

/// The path will be begun anew.
void FrameToFrameVo::Tracker::GiveUp() {
  map_.Clear();
  chosen_.reset();
  has_points_ = false;
  start_frames_ = start_misses_ = 0;
}

FrameToFrameVoOptions FrameToFrameVoOptions::WithFeature(const std::string& feature, double sensitivity) {
  FrameToFrameVoOptions options;
  options.feature = feature;
  options.sensitivity = sensitivity;
  return options;
}

Words FeatureNames() {
  Words names;
  for (const FeatureInfo& info : ListFeatures()) names.words.push_back(info.name);
  return names;
}

FrameToFrameVo::FrameToFrameVo(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed) {
  camera.Check();
  CheckFields(options, "frame_to_frame_vo.");
  tracker_ = std::make_unique<Tracker>(camera, options, seed);
}

FrameToFrameVo::~FrameToFrameVo() = default;

FrameEstimate FrameToFrameVo::Track(const Observation& observation) { return tracker_->Track(observation); }

std::vector<FrameEstimate> FrameToFrameVo::Finish() const { return tracker_->Finish(); }

}  // namespace gaitcam
