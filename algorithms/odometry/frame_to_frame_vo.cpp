#include "algorithms/odometry/frame_to_frame_vo.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "algorithms/core/random.h"
#include "algorithms/geometry/absolute_pose.h"
#include "algorithms/geometry/relative_motion.h"
#include "algorithms/geometry/robust.h"
#include "algorithms/geometry/triangulation.h"
#include "algorithms/geometry/two_view.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kFlat = 5;  // times the parallax is asked of a start that looks like a plane

double Median(std::vector<double> values) {
  GAITCAM_ASSERT(!values.empty());
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// One thing in the world: the rays of chosen frames that saw it and, once these meet at an angle, where it is.
struct Landmark {
  std::vector<RayObservation> rays;
  std::optional<Eigen::Vector3d> p_W;
};

/// A frame's features and their rays.
struct View {
  Features features;
  std::vector<Eigen::Vector2d> xy;  ///< Undistorted normalised coordinates, one per feature.
  Pose X_WC;
};

}  // namespace

class FrameToFrameVo::Tracker {
 public:
  Tracker(const CameraModel& camera, const FrameToFrameVoOptions& options, uint64_t seed)
      : camera_(camera),
        options_(options),
        detector_(MakeFeature2d(options.feature, options.sensitivity)),
        random_(seed, "frame_to_frame_vo"),
        threshold_(options.threshold_px / camera.fx) {}

  FrameEstimate Track(const Observation& observation);

 private:
  View Look(const cv::Mat& image) const;
  std::vector<Match> MatchWithChosen(const View& view) const;
  std::vector<PointPair> PairsOf(const View& view, const std::vector<Match>& matches) const;
  RansacOptions Robustly() const;

  bool Start(View& view, const std::vector<Match>& matches);
  bool BeginReconstruction(View& view, const std::vector<Match>& matches, const TwoView& two_view);
  bool Follow(View& view, const std::vector<Match>& matches);
  bool PlaceByPoints(View& view, const std::vector<Match>& matches);
  bool PlaceByTwoViews(View& view, const std::vector<Match>& matches);
  std::optional<double> ScaleFromCommonPoints(const View& view, const std::vector<Match>& matches,
                                              const TwoView& two_view);
  TwoView Reconstruct(const std::vector<PointPair>& pairs);
  bool MakesAPair(const View& view) const;
  void Choose(View view, const std::vector<Match>& matches);
  bool Triangulate(Landmark& landmark) const;

  CameraModel camera_;
  FrameToFrameVoOptions options_;
  cv::Ptr<cv::Feature2D> detector_;
  RandomStream random_;
  double threshold_;  ///< Normalised coordinates.

  std::optional<View> chosen_;       ///< The last chosen frame: first view of the next pair.
  std::vector<Landmark> landmarks_;  ///< One per feature of it.
  int points_ = 0;                   ///< Landmarks with a place; 0: no reconstruction yet.
  std::vector<int> inliers_;         ///< Features of the chosen frame that agree with the present pose.

  std::optional<Pose> X_WC_last_;  ///< Last known pose, over all restarts.
  double median_depth_ = 1;        ///< In the last chosen frame; the unit when a path begins.
  int lost_frames_ = 0;
  int start_frames_ = 0;  ///< Frames since there was a reconstruction, or since the first.
  int start_misses_ = 0;  ///< Of these the latest that could not be matched with the chosen one.
};

FrameEstimate FrameToFrameVo::Tracker::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  View view = Look(observation.image.pixels);
  answer.features = view.features.size();
  const bool had_points = points_ > 0;
  const std::vector<Match> matches = MatchWithChosen(view);
  const bool found = had_points ? Follow(view, matches) : Start(view, matches);
  answer.inliers = int(inliers_.size());
  if (found) {
    lost_frames_ = 0;
    answer.status = TrackingStatus::kTracking;
    answer.pose = view.X_WC;
    answer.restarted = !had_points && X_WC_last_.has_value();
    X_WC_last_ = view.X_WC;
    if (!had_points || MakesAPair(view)) Choose(std::move(view), matches);
    return answer;
  }
  answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  if (had_points && ++lost_frames_ > options_.max_lost_frames) {
    chosen_.reset();
    points_ = 0;
  }
  return answer;
}

/// Step 1.
View FrameToFrameVo::Tracker::Look(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  View view;
  view.features = DetectFeatures(*detector_, image, options_.max_features);
  for (const cv::KeyPoint& keypoint : view.features.keypoints) {
    view.xy.push_back(camera_.Unproject({keypoint.pt.x, keypoint.pt.y}).head<2>());
  }
  return view;
}

/// Step 2.
std::vector<Match> FrameToFrameVo::Tracker::MatchWithChosen(const View& view) const {
  if (!chosen_) return {};
  return MatchDescriptors(chosen_->features.descriptors, view.features.descriptors, options_.matching);
}

std::vector<PointPair> FrameToFrameVo::Tracker::PairsOf(const View& view, const std::vector<Match>& matches) const {
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
  if (int(found.inliers.size()) < options_.min_matches) return {};
  if (options_.refine) return RefineTwoView(pairs, found.model, found.inliers, threshold_);
  const RelativeMotion motion = ChooseByDepth(found.model, pairs, found.inliers);
  return DescribeTwoView(pairs, motion, threshold_);
}

/// Without a reconstruction: waits until the camera has moved enough since the chosen frame to see parallax. A few
/// frames that cannot be matched (blurred, covered) do not matter.
bool FrameToFrameVo::Tracker::Start(View& view, const std::vector<Match>& matches) {
  inliers_.clear();
  ++start_frames_;
  TwoView two_view;
  if (int(matches.size()) >= options_.min_start_points) two_view = Reconstruct(PairsOf(view, matches));
  if (int(two_view.inliers.size()) < options_.min_start_points) {
    if (chosen_ && ++start_misses_ <= options_.max_start_misses) return false;
    chosen_.reset();
    start_misses_ = 0;
    if (view.features.size() >= options_.min_start_points) chosen_ = std::move(view);
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

/// Triangulates the inliers; the unit is such that their median depth is that of the path before (1 at first).
bool FrameToFrameVo::Tracker::BeginReconstruction(View& view, const std::vector<Match>& matches,
                                                  const TwoView& two_view) {
  std::vector<Landmark> landmarks(chosen_->xy.size());
  std::vector<double> depths;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    Landmark& landmark = landmarks[size_t(match.a)];
    landmark.rays = {{Pose(), chosen_->xy[size_t(match.a)]}, {two_view.X_AB, view.xy[size_t(match.b)]}};
    if (!Triangulate(landmark)) continue;
    depths.push_back(landmark.p_W->z());
    inliers_.push_back(match.a);
  }
  if (int(depths.size()) < options_.min_start_points) return false;
  const double unit = median_depth_ / Median(depths);
  chosen_->X_WC = X_WC_last_.value_or(Pose());
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, unit * two_view.X_AB.translation);
  for (size_t i = 0; i < landmarks.size(); ++i) {
    landmarks[i].rays = {{chosen_->X_WC, chosen_->xy[i]}};  // the present frame's ray joins when it is chosen
    if (landmarks[i].p_W) landmarks[i].p_W = chosen_->X_WC * (unit * *landmarks[i].p_W);
  }
  landmarks_ = std::move(landmarks);
  return true;
}

/// With a reconstruction: the pose from its points and, where the frame makes a pair, from the two views.
bool FrameToFrameVo::Tracker::Follow(View& view, const std::vector<Match>& matches) {
  const bool placed = PlaceByPoints(view, matches);
  if (options_.placing == "points" || (placed && !MakesAPair(view))) return placed;
  return PlaceByTwoViews(view, matches) || placed;
}

bool FrameToFrameVo::Tracker::PlaceByPoints(View& view, const std::vector<Match>& matches) {
  std::vector<PointSighting> sightings;
  std::vector<int> feature;
  for (const Match& match : matches) {
    const Landmark& landmark = landmarks_[size_t(match.a)];
    if (!landmark.p_W) continue;
    sightings.push_back({*landmark.p_W, view.xy[size_t(match.b)]});
    feature.push_back(match.a);
  }
  const auto found = EstimateAbsolutePose(sightings, Robustly(), random_, X_WC_last_);
  inliers_.clear();
  for (const int i : found.inliers) inliers_.push_back(feature[size_t(i)]);
  view.X_WC = found.model;
  return int(inliers_.size()) >= options_.min_matches;
}

/// Steps 3 to 6 between the last chosen frame and this one. Leaves `view` alone where the two views do not tell.
bool FrameToFrameVo::Tracker::PlaceByTwoViews(View& view, const std::vector<Match>& matches) {
  if (int(matches.size()) < options_.min_matches) return false;
  const TwoView two_view = Reconstruct(PairsOf(view, matches));
  if (two_view.inliers.empty() || two_view.rotation_only || two_view.alternative) return false;
  if (two_view.direction_sigma > options_.max_direction_deg * kRadPerDeg) return false;
  const std::optional<double> scale = ScaleFromCommonPoints(view, matches, two_view);
  if (!scale) return false;
  view.X_WC = chosen_->X_WC * Pose(two_view.X_AB.rotation, *scale * two_view.X_AB.translation);
  inliers_.clear();
  for (const int i : two_view.inliers) inliers_.push_back(matches[size_t(i)].a);
  return true;
}

/// Step 6: RANSAC on the ratios of depths in the chosen frame, of the reconstruction so far over that of the pair.
std::optional<double> FrameToFrameVo::Tracker::ScaleFromCommonPoints(const View& view,
                                                                     const std::vector<Match>& matches,
                                                                     const TwoView& two_view) {
  const Pose X_CW = chosen_->X_WC.Inverse();
  std::vector<double> log_ratios;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    const std::optional<Eigen::Vector3d>& known = landmarks_[size_t(match.a)].p_W;
    if (!known) continue;
    Landmark landmark;
    landmark.rays = {{Pose(), chosen_->xy[size_t(match.a)]}, {two_view.X_AB, view.xy[size_t(match.b)]}};
    const double known_depth = (X_CW * *known).z();
    if (known_depth > 0 && Triangulate(landmark)) log_ratios.push_back(std::log(known_depth / landmark.p_W->z()));
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

bool FrameToFrameVo::Tracker::MakesAPair(const View& view) const {
  if (options_.pair_displacement_px == 0) return true;
  if (double(inliers_.size()) < options_.pair_overlap * points_) return true;
  std::vector<double> angles;
  for (const int i : inliers_) {
    const std::optional<Eigen::Vector3d>& p_W = landmarks_[size_t(i)].p_W;
    if (p_W) angles.push_back(ParallaxAngle(*p_W, {{chosen_->X_WC, {}}, {view.X_WC, {}}}));
  }
  return angles.empty() || Median(angles) * camera_.fx > options_.pair_displacement_px;
}

/// Places what a landmark is, if its rays meet at an angle and agree.
bool FrameToFrameVo::Tracker::Triangulate(Landmark& landmark) const {
  const auto p_W = TriangulatePoint(landmark.rays);
  if (!p_W || ParallaxAngle(*p_W, landmark.rays) < options_.min_parallax_deg * kRadPerDeg) return false;
  for (const RayObservation& ray : landmark.rays) {
    if (ReprojectionError(*p_W, ray) > threshold_) return false;
  }
  landmark.p_W = p_W;
  return true;
}

/// Frames are matched with `view` from now on. Landmarks that it sees gain a ray, which places them or sharpens their
/// place; the others are forgotten.
void FrameToFrameVo::Tracker::Choose(View view, const std::vector<Match>& matches) {
  std::vector<Landmark> landmarks(view.xy.size());
  for (size_t i = 0; i < landmarks.size(); ++i) landmarks[i].rays = {{view.X_WC, view.xy[i]}};
  for (const Match& match : matches) {
    const RayObservation here = {view.X_WC, view.xy[size_t(match.b)]};
    Landmark landmark = landmarks_[size_t(match.a)];
    if (landmark.p_W && ReprojectionError(*landmark.p_W, here) > threshold_) continue;  // not the same thing
    landmark.rays.push_back(here);
    if (int(landmark.rays.size()) > options_.max_rays) {
      // The first stays, as the one farthest away; of two only, they are the present pair.
      landmark.rays.erase(landmark.rays.begin() + (options_.max_rays > 2 ? 1 : 0));
    }
    Triangulate(landmark);
    landmarks[size_t(match.b)] = std::move(landmark);
  }
  std::vector<double> depths;
  for (const Landmark& landmark : landmarks) {
    if (landmark.p_W) depths.push_back((view.X_WC.Inverse() * *landmark.p_W).z());
  }
  landmarks_ = std::move(landmarks);
  points_ = int(depths.size());
  if (!depths.empty()) median_depth_ = Median(depths);
  chosen_ = std::move(view);
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

}  // namespace gaitcam
