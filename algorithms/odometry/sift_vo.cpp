#include "algorithms/odometry/sift_vo.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/random.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/absolute_pose.h"
#include "algorithms/geometry/triangulation.h"
#include "algorithms/geometry/two_view.h"

namespace gaitcam {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr size_t kMostRays = 12;  // per point: the first stays, as the one farthest away; then the latest

double Median(std::vector<double> values) {
  GAITCAM_ASSERT(!values.empty());
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// One thing in the world: the keyframe rays that saw it and, once these meet at an angle, where it is.
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

class SiftVo::Tracker {
 public:
  Tracker(const CameraModel& camera, const SiftVoOptions& options, uint64_t seed)
      : camera_(camera), options_(options), random_(seed, "sift_vo"), threshold_(options.threshold_px / camera.fx) {}

  FrameEstimate Track(const Observation& observation);

 private:
  View Look(const cv::Mat& image) const;
  std::vector<Match> MatchWithKeyframe(const View& view) const;
  RansacOptions Ransacking() const { return {threshold_, options_.ransac_confidence, options_.ransac_iterations}; }

  bool Start(View& view, const std::vector<Match>& matches);
  bool BuildMap(View& view, const std::vector<Match>& matches, const TwoView& two_view);
  bool Locate(View& view, const std::vector<Match>& matches);
  bool WantsKeyframe(const View& view) const;
  void MakeKeyframe(View view, const std::vector<Match>& matches);
  bool Triangulate(Landmark& landmark) const;

  CameraModel camera_;
  SiftVoOptions options_;
  RandomStream random_;
  double threshold_;  ///< Normalised coordinates.

  std::optional<View> keyframe_;     ///< What frames are matched with.
  std::vector<Landmark> landmarks_;  ///< One per feature of the keyframe.
  int keyframe_points_ = 0;          ///< Landmarks with a place; 0: no map yet.
  std::vector<int> inliers_;         ///< Features of the keyframe whose places gave the present pose.

  std::optional<Pose> X_WC_last_;  ///< Last known pose, over all maps.
  double median_depth_ = 1;        ///< In the last keyframe; the unit when a map begins.
  int lost_frames_ = 0;
};

FrameEstimate SiftVo::Tracker::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  View view = Look(observation.image.pixels);
  answer.features = view.features.size();
  const bool had_map = keyframe_points_ > 0;
  const std::vector<Match> matches = MatchWithKeyframe(view);
  const bool found = had_map ? Locate(view, matches) : Start(view, matches);
  answer.inliers = int(inliers_.size());
  if (found) {
    lost_frames_ = 0;
    answer.status = TrackingStatus::kTracking;
    answer.pose = view.X_WC;
    answer.restarted = !had_map && X_WC_last_.has_value();
    X_WC_last_ = view.X_WC;
    if (!had_map || WantsKeyframe(view)) MakeKeyframe(std::move(view), matches);
    return answer;
  }
  answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  if (had_map && ++lost_frames_ > options_.max_lost_frames) {
    keyframe_.reset();
    keyframe_points_ = 0;
  }
  return answer;
}

View SiftVo::Tracker::Look(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  View view;
  view.features = DetectFeatures(*MakeFeature2d("sift", options_.sensitivity), image, options_.max_features);
  for (const cv::KeyPoint& keypoint : view.features.keypoints) {
    view.xy.push_back(camera_.Unproject({keypoint.pt.x, keypoint.pt.y}).head<2>());
  }
  return view;
}

std::vector<Match> SiftVo::Tracker::MatchWithKeyframe(const View& view) const {
  if (!keyframe_) return {};
  MatchingOptions matching;
  matching.ratio = options_.ratio;
  return MatchDescriptors(keyframe_->features.descriptors, view.features.descriptors, matching);
}

/// Without a map: waits until the camera has moved enough since the keyframe to see parallax, then builds one.
bool SiftVo::Tracker::Start(View& view, const std::vector<Match>& matches) {
  inliers_.clear();
  const auto begin_here = [&] {
    keyframe_.reset();
    if (view.features.size() >= options_.min_start_points) keyframe_ = std::move(view);
    return false;
  };
  if (!keyframe_ || int(matches.size()) < options_.min_start_points) return begin_here();
  std::vector<PointPair> pairs;
  for (const Match& match : matches) pairs.push_back({keyframe_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
  const TwoView two_view = EstimateTwoView(pairs, Ransacking(), random_);
  if (int(two_view.inliers.size()) < options_.min_start_points) return begin_here();
  // It only turned, or hardly moved: whatever was computed means nothing yet.
  if (two_view.parallax < options_.start_parallax_deg * kRadPerDeg) return false;
  if (two_view.direction_sigma > options_.start_direction_deg * kRadPerDeg) return false;
  return BuildMap(view, matches, two_view);
}

/// Triangulates the start's inliers; the unit is such that their median depth is that of the map before (1 at first).
bool SiftVo::Tracker::BuildMap(View& view, const std::vector<Match>& matches, const TwoView& two_view) {
  std::vector<Landmark> landmarks(keyframe_->xy.size());
  std::vector<double> depths;
  for (const int i : two_view.inliers) {
    const Match& match = matches[size_t(i)];
    Landmark& landmark = landmarks[size_t(match.a)];
    landmark.rays = {{Pose(), keyframe_->xy[size_t(match.a)]}, {two_view.X_AB, view.xy[size_t(match.b)]}};
    if (!Triangulate(landmark)) continue;
    depths.push_back(landmark.p_W->z());
    inliers_.push_back(match.a);
  }
  if (int(depths.size()) < options_.min_start_points) return false;
  const double unit = median_depth_ / Median(depths);
  keyframe_->X_WC = X_WC_last_.value_or(Pose());
  view.X_WC = keyframe_->X_WC * Pose(two_view.X_AB.rotation, unit * two_view.X_AB.translation);
  for (size_t i = 0; i < landmarks.size(); ++i) {
    landmarks[i].rays = {
        {keyframe_->X_WC, keyframe_->xy[i]}};  // the present frame's ray joins when it is made a keyframe
    if (landmarks[i].p_W) landmarks[i].p_W = keyframe_->X_WC * (unit * *landmarks[i].p_W);
  }
  landmarks_ = std::move(landmarks);
  return true;
}

/// Places what a landmark is, if its rays meet at an angle and agree.
bool SiftVo::Tracker::Triangulate(Landmark& landmark) const {
  const auto p_W = TriangulatePoint(landmark.rays);
  if (!p_W || ParallaxAngle(*p_W, landmark.rays) < options_.min_parallax_deg * kRadPerDeg) return false;
  for (const RayObservation& ray : landmark.rays) {
    if (ReprojectionError(*p_W, ray) > threshold_) return false;
  }
  landmark.p_W = p_W;
  return true;
}

/// With a map: the pose from the keyframe's points that are seen again.
bool SiftVo::Tracker::Locate(View& view, const std::vector<Match>& matches) {
  std::vector<PointSighting> sightings;
  std::vector<int> feature;
  for (const Match& match : matches) {
    const Landmark& landmark = landmarks_[size_t(match.a)];
    if (!landmark.p_W) continue;
    sightings.push_back({*landmark.p_W, view.xy[size_t(match.b)]});
    feature.push_back(match.a);
  }
  const auto found = EstimateAbsolutePose(sightings, Ransacking(), random_, X_WC_last_);
  inliers_.clear();
  for (const int i : found.inliers) inliers_.push_back(feature[size_t(i)]);
  view.X_WC = found.model;
  return int(inliers_.size()) >= options_.min_matches;
}

bool SiftVo::Tracker::WantsKeyframe(const View& view) const {
  if (double(inliers_.size()) < options_.keyframe_overlap * keyframe_points_) return true;
  std::vector<double> angles;
  for (const int i : inliers_) {
    angles.push_back(ParallaxAngle(*landmarks_[size_t(i)].p_W, {{keyframe_->X_WC, {}}, {view.X_WC, {}}}));
  }
  return Median(angles) > options_.keyframe_parallax_deg * kRadPerDeg;
}

/// Frames are matched with `view` from now on. Landmarks that it sees gain a ray, which places them or sharpens their
/// place; the others are forgotten.
void SiftVo::Tracker::MakeKeyframe(View view, const std::vector<Match>& matches) {
  std::vector<Landmark> landmarks(view.xy.size());
  for (size_t i = 0; i < landmarks.size(); ++i) landmarks[i].rays = {{view.X_WC, view.xy[i]}};
  for (const Match& match : matches) {
    const RayObservation here = {view.X_WC, view.xy[size_t(match.b)]};
    Landmark landmark = landmarks_[size_t(match.a)];
    if (landmark.p_W && ReprojectionError(*landmark.p_W, here) > threshold_) continue;  // not the same thing
    landmark.rays.push_back(here);
    if (landmark.rays.size() > kMostRays) landmark.rays.erase(landmark.rays.begin() + 1);
    Triangulate(landmark);
    landmarks[size_t(match.b)] = std::move(landmark);
  }
  landmarks_ = std::move(landmarks);
  std::vector<double> depths;
  for (const Landmark& landmark : landmarks_) {
    if (landmark.p_W) depths.push_back((view.X_WC.Inverse() * *landmark.p_W).z());
  }
  keyframe_points_ = int(depths.size());
  median_depth_ = Median(depths);
  keyframe_ = std::move(view);
}

SiftVo::SiftVo(const CameraModel& camera, const SiftVoOptions& options, uint64_t seed) {
  camera.Check();
  CheckFields(options, "sift_vo.");
  tracker_ = std::make_unique<Tracker>(camera, options, seed);
}

SiftVo::~SiftVo() = default;

FrameEstimate SiftVo::Track(const Observation& observation) { return tracker_->Track(observation); }

}  // namespace gaitcam
