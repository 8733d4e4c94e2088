#include "algorithms/odometry/frame_to_frame_vo.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "algorithms/core/median.h"
#include "algorithms/core/random.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"
#include "algorithms/geometry/triangulation.h"
#include "algorithms/geometry/two_view.h"
#include "algorithms/odometry/floor_guess.h"
#include "algorithms/odometry/landmark_map.h"
#include "algorithms/odometry/landmark_pose.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kFlat = 5;  // times the parallax is asked of a start that looks like a plane

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

}  // namespace

class FrameToFrameVo::Tracker {
 public:
  Tracker(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed)
      : camera_(camera),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "frame_to_frame_vo"),
        threshold_(options.threshold_px / camera.fx),
        placer_(camera.fx, options.matching.ratio, options.landmarks),
        map_(MapOptions(options)) {}

  FrameEstimate Track(const Observation& observation) {
    const FrameEstimate answer = Answer(observation);
    records_.push_back({answer, -1, Pose()});
    if (answer.pose) Attach(records_.back(), *answer.pose);
    if (has_points_ && !waiting_.empty()) PlaceWaiting(observation.stamp_ns);
    return answer;
  }
  std::vector<FrameEstimate> Finish() const;

 private:
  FrameEstimate Answer(const Observation& observation);
  std::vector<Match> MatchWithChosen(const FrameView& view) const;
  std::vector<PointPair> PairsOf(const FrameView& view, const std::vector<Match>& matches) const;
  RansacOptions Robustly() const;
  LandmarkMap::Guess Guess() const {
    return [this](const Pose& X_WC, const Eigen::Vector2d& xy) { return floor_.At(X_WC, xy); };
  }
  PositionPrior Expect(int64_t stamp_ns) const {
    return placer_.Expect(X_WC_last_->translation, stamp_ns - last_ns_, median_depth_);
  }
  bool ByPointsAlone() const { return options_.placing == "points"; }

  bool Start(FrameView& view);
  bool BeginReconstruction(FrameView& view, const std::vector<Match>& matches, const TwoView& two_view);
  void PlaceWaiting(int64_t stamp_ns);
  void PlaceMissed(const FrameView& view, int64_t stamp_ns);
  void Attach(FrameRecord& record, const Pose& X_WC) const;
  void Attach(FrameRecord& record, const LandmarkPose& placed) const;
  bool Follow(FrameView& view, int64_t stamp_ns);
  bool PlaceByPoints(FrameView& view, int64_t stamp_ns);
  bool PlaceByTwoViews(FrameView& view);
  std::optional<double> ScaleFromCommonPoints(const FrameView& view, const std::vector<Match>& matches,
                                              const TwoView& two_view);
  TwoView Reconstruct(const std::vector<PointPair>& pairs);
  bool IsPairDue(const FrameView& view) const;
  bool MakesAPair(const FrameView& view);
  void Choose(FrameView& view);
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
  LandmarkPlacer placer_;
  FloorGuess floor_;
  LandmarkMap map_;                     ///< The points that the latest chosen frames saw.
  bool has_points_ = false;             ///< false: no reconstruction yet.
  std::vector<LandmarkMatch> inliers_;  ///< That agree with the present pose.
  int most_inliers_ = 0;                ///< Of a frame since the last chosen one.
  double chosen_inliers_ = 0;           ///< Of the last chosen frame.
  double usual_inliers_ = 0;            ///< Per frame, lately.
  int waiting_frames_ = 0;              ///< Since a pair was due.

  std::optional<Pose> X_WC_last_;  ///< Last known pose, over all restarts.
  int64_t last_ns_ = 0;            ///< Its stamp.
  double median_depth_ = 1;        ///< In the last chosen frame; the unit when a path begins.
  int lost_frames_ = 0;
  int start_frames_ = 0;  ///< Frames since there was a reconstruction, or since the first.
  int start_misses_ = 0;  ///< Of these the latest that could not be matched with the chosen one.
  struct Waiting {
    size_t record = 0;
    FrameView view;
    int64_t stamp_ns = 0;
  };
  std::vector<Waiting> waiting_;  ///< Frames for the reconstruction to place once there is one.
  std::vector<Waiting> missed_;   ///< Frames without a pose since the last one that has one.
  std::vector<FrameRecord> records_;
};

FrameEstimate FrameToFrameVo::Tracker::Answer(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  FrameView view = ViewFrame(observation.image.pixels, camera_, *detector_, options_.max_features,
                             {options_.landmarks.sigma_px, options_.landmarks.sigma_per_size});  // step 1
  answer.features = view.features.size();
  inliers_.clear();
  const bool had_points = has_points_;
  const bool found = had_points ? Follow(view, answer.stamp_ns) : Start(view);
  answer.inliers = int(inliers_.size());
  if (!found) {
    constexpr size_t kMostWaiting = 60;  // frames: their features take memory
    std::vector<Waiting>& later = had_points ? missed_ : waiting_;
    if (later.size() < kMostWaiting) later.push_back({records_.size(), std::move(view), answer.stamp_ns});
    answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
    if (had_points && ++lost_frames_ > options_.max_lost_frames) GiveUp();
    return answer;
  }
  lost_frames_ = 0;
  answer.status = TrackingStatus::kTracking;
  answer.restarted = !had_points && X_WC_last_.has_value();
  if (had_points) {
    answer.restarted = !LandmarkPlacer::IsWithinReach(Expect(answer.stamp_ns), view.X_WC);
    if (MakesAPair(view)) {
      Choose(view);
    } else {
      map_.Refresh(view, inliers_);
    }
    PlaceMissed(view, answer.stamp_ns);
  }
  answer.pose = X_WC_last_ = view.X_WC;
  last_ns_ = answer.stamp_ns;
  return answer;
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

/// Steps 3 to 5: hypotheses from five pairs, the best by distances from epipolar lines, the decomposition with most
/// points in front.
TwoView FrameToFrameVo::Tracker::Reconstruct(const std::vector<PointPair>& pairs) {
  const auto found = EstimateEssential(pairs, Robustly(), random_, EpipolarDistance2);
  if (int(found.inliers.size()) < options_.landmarks.min_inliers) return {};
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
  const double unit = median_depth_ / UpperMedian(known);
  chosen_->X_WC = X_WC_last_.value_or(Pose());
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, unit * two_view.X_AB.translation);
  map_.AddKeyframe(*chosen_, {}, median_depth_, Guess());  // its features are the map's landmarks now, in order
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (depths[i]) map_.SetDepth(pairs[i].landmark, 1 / (unit * *depths[i]));
  }
  inliers_ = pairs;
  has_points_ = true;
  Choose(view);
  return true;
}

/// For the final word, from the latest back to the first. A new path is marked where it now begins.
void FrameToFrameVo::Tracker::PlaceWaiting(int64_t stamp_ns) {
  LandmarkPoseGuess guess;
  guess.X_WC = *X_WC_last_;
  guess.usual_inliers = double(inliers_.size());
  size_t begin = records_.size() - 1;
  for (auto frame = waiting_.rbegin(); frame != waiting_.rend(); ++frame) {
    guess.prior = placer_.Expect(guess.X_WC.translation, stamp_ns - frame->stamp_ns, median_depth_);
    const auto placed = placer_.PlaceWithNoise(map_, frame->view, guess, 1, random_);
    if (!placed || !LandmarkPlacer::IsWithinReach(*guess.prior, placed->X_WC)) continue;
    guess.X_WC = placed->X_WC;
    stamp_ns = frame->stamp_ns;
    begin = frame->record;
    Attach(records_[begin], *placed);
  }
  std::swap(records_[begin].answer.restarted, records_.back().answer.restarted);
  waiting_.clear();
}

/// Frames that were lost between two that have a pose have better expectations now: for the final word.
void FrameToFrameVo::Tracker::PlaceMissed(const FrameView& view, int64_t stamp_ns) {
  const StampedPlace before{*X_WC_last_, last_ns_}, after{view.X_WC, stamp_ns};
  for (const Waiting& frame : missed_) {
    const auto placed =
        placer_.PlaceBetween(map_, frame.view, frame.stamp_ns, before, after, median_depth_, usual_inliers_, random_);
    if (placed) Attach(records_[frame.record], *placed);
  }
  missed_.clear();
}

void FrameToFrameVo::Tracker::Attach(FrameRecord& record, const Pose& X_WC) const {
  record.answer.pose = X_WC;
  record.chosen = int(map_.keyframes().size()) - 1;
  record.X_KC = map_.keyframes().back().Inverse() * X_WC;
}

void FrameToFrameVo::Tracker::Attach(FrameRecord& record, const LandmarkPose& placed) const {
  record.answer.status = TrackingStatus::kTracking;
  record.answer.inliers = int(placed.inliers.size());
  Attach(record, placed.X_WC);
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
bool FrameToFrameVo::Tracker::Follow(FrameView& view, int64_t stamp_ns) {
  const bool placed = PlaceByPoints(view, stamp_ns);
  if (ByPointsAlone() || (placed && !IsPairDue(view))) return placed;
  return PlaceByTwoViews(view) || placed;
}

bool FrameToFrameVo::Tracker::PlaceByPoints(FrameView& view, int64_t stamp_ns) {
  LandmarkPoseGuess guess;
  guess.X_WC = *X_WC_last_;
  guess.prior = Expect(stamp_ns);
  guess.usual_inliers = usual_inliers_ > 0 ? usual_inliers_ : chosen_inliers_;
  const auto placed = placer_.Place(map_, view, guess, random_);
  if (!placed) return false;
  view.X_WC = placed->X_WC;
  inliers_ = placed->inliers;
  return true;
}

/// Steps 3 to 6 between the last chosen frame and this one. Leaves `view` alone where the two views do not tell.
bool FrameToFrameVo::Tracker::PlaceByTwoViews(FrameView& view) {
  const std::vector<Match> matches = MatchWithChosen(view);
  if (int(matches.size()) < options_.landmarks.min_inliers) return false;
  const TwoView two_view = Reconstruct(PairsOf(view, matches));
  if (two_view.inliers.empty() || two_view.rotation_only || two_view.alternative) return false;
  if (two_view.direction_sigma > options_.max_direction_deg * kRadPerDeg) return false;
  const std::optional<double> scale = ScaleFromCommonPoints(view, matches, two_view);
  if (!scale) return false;
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, *scale * two_view.X_AB.translation);
  inliers_ = placer_.Find(map_, view);
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
  if (int(found.inliers.size()) < options_.landmarks.min_inliers) return std::nullopt;
  double mean = 0;
  for (const int i : found.inliers) mean += log_ratios[size_t(i)] / double(found.inliers.size());
  return std::exp(mean);
}

/// A pair is due once the points have moved, the camera has turned, or points are out of sight.
bool FrameToFrameVo::Tracker::IsPairDue(const FrameView& view) const {
  if (options_.pair_displacement_px == 0) return true;
  if (usual_inliers_ < options_.pair_overlap * most_inliers_) return true;
  if (RotationAngle(chosen_->X_WC.rotation, view.X_WC.rotation) > options_.pair_turn_deg * kRadPerDeg) return true;
  return camera_.fx * map_.MedianParallax(inliers_, chosen_->X_WC.translation, view.X_WC.translation) >
         options_.pair_displacement_px;
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
  const bool in_danger = inliers < 2 * options_.landmarks.min_inliers;
  return inliers >= usual_inliers_ || in_danger || waiting_frames_ > options_.max_wait_frames;
}

/// Points that `view` sees gain a ray, which places them or sharpens their place; all else that it sees may become one.
void FrameToFrameVo::Tracker::Choose(FrameView& view) {
  if (!inliers_.empty()) ScaleNoise(map_, inliers_, view);
  map_.AddKeyframe(view, inliers_, median_depth_, Guess());
  median_depth_ = map_.MedianDepth(view.X_WC, median_depth_);
  if (ByPointsAlone()) {
    if (options_.use_floor) floor_.Update(map_, view.X_WC, random_);
  } else {
    depths_ = DepthsOfPair(view);
  }
  chosen_ = view;
  chosen_inliers_ = double(inliers_.size());
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
  floor_.Clear();
  missed_.clear();
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
