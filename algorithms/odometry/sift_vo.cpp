#include "algorithms/odometry/sift_vo.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/random.h"
#include "algorithms/features/matching.h"
#include "algorithms/features/sift.h"
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

/// A point of the map and the keyframe rays that made it.
struct MapPoint {
  Eigen::Vector3d p_W;
  std::vector<RayObservation> rays;
};

/// A frame's features, their rays, and which point of the map each one shows.
struct View {
  Features features;
  std::vector<Eigen::Vector2d> xy;  ///< Undistorted normalised coordinates, one per feature.
  std::vector<int> point;           ///< Index of the map point, -1: none (yet); one per feature.
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

  bool Start(View& view, FrameEstimate& answer);
  bool BuildMap(View& view, const std::vector<Match>& matches, const std::vector<PointPair>& pairs,
                const TwoView& two_view);
  bool Locate(View& view, FrameEstimate& answer);
  bool WantsKeyframe(const View& view) const;
  void ExtendMap(View& view, const std::vector<Match>& matches);
  void MakeKeyframe(View view);
  int PointsSeen(const View& view) const {
    return int(std::count_if(view.point.begin(), view.point.end(), [](int p) { return p >= 0; }));
  }

  CameraModel camera_;
  SiftVoOptions options_;
  RandomStream random_;
  double threshold_;              ///< Normalised coordinates.
  std::optional<View> keyframe_;  ///< What frames are matched with.
  std::vector<MapPoint> map_;     ///< The points that the keyframe shows; empty: no map yet.
  int keyframe_points_ = 0;
  std::vector<Match> matches_;     ///< Keyframe feature a, present feature b.
  std::optional<Pose> X_WC_last_;  ///< Last known pose, over all maps.
  double median_depth_ = 1;        ///< In the last keyframe; the unit when a map begins.
  int lost_frames_ = 0;
};

FrameEstimate SiftVo::Tracker::Track(const Observation& observation) {
  FrameEstimate answer;
  answer.stamp_ns = observation.stamp_ns;
  View view = Look(observation.image.pixels);
  answer.features = view.features.size();
  const bool found = map_.empty() ? Start(view, answer) : Locate(view, answer);
  if (found) {
    lost_frames_ = 0;
    X_WC_last_ = view.X_WC;
    answer.status = TrackingStatus::kTracking;
    answer.pose = view.X_WC;
    if (WantsKeyframe(view)) {
      ExtendMap(view, matches_);
      MakeKeyframe(std::move(view));
    }
    return answer;
  }
  answer.status = X_WC_last_ ? TrackingStatus::kLost : TrackingStatus::kInitializing;
  if (!map_.empty() && ++lost_frames_ > options_.max_lost_frames) {
    map_.clear();
    keyframe_.reset();
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
  SiftOptions sift;
  sift.max_features = options_.max_features;
  sift.contrast_threshold = options_.contrast_threshold;
  view.features = DetectSift(image, sift);
  for (const cv::Point2f& pixel : view.features.pixels) {
    view.xy.push_back(camera_.Unproject({pixel.x, pixel.y}).head<2>());
  }
  view.point.assign(view.xy.size(), -1);
  return view;
}

std::vector<Match> SiftVo::Tracker::MatchWithKeyframe(const View& view) const {
  MatchingOptions matching;
  matching.ratio = options_.ratio;
  return MatchDescriptors(keyframe_->features.descriptors, view.features.descriptors, matching);
}

/// Without a map: waits until the camera has moved sideways enough since the keyframe, then builds one.
bool SiftVo::Tracker::Start(View& view, FrameEstimate& answer) {
  const auto begin_here = [&] {
    if (view.features.size() < options_.min_start_points) {
      keyframe_.reset();
    } else {
      keyframe_ = std::move(view);
    }
    return false;
  };
  if (!keyframe_) return begin_here();
  matches_ = MatchWithKeyframe(view);
  if (int(matches_.size()) < options_.min_start_points) return begin_here();
  std::vector<PointPair> pairs;
  std::vector<double> moved;
  for (const Match& match : matches_) {
    pairs.push_back({keyframe_->xy[size_t(match.a)], view.xy[size_t(match.b)]});
    moved.push_back((pairs.back().a - pairs.back().b).norm());
  }
  // Rays turn by at least what they appear to move: without that there can be no parallax, and nothing to compute.
  if (Median(moved) < options_.start_parallax_deg * kRadPerDeg / 2) return false;
  const TwoView two_view = EstimateTwoView(pairs, Ransacking(), random_);
  if (int(two_view.inliers.size()) < options_.min_start_points) return begin_here();
  if (two_view.parallax < options_.start_parallax_deg * kRadPerDeg) return false;  // it only turned, or hardly moved
  if (!BuildMap(view, matches_, pairs, two_view)) return false;
  answer.inliers = PointsSeen(view);
  answer.restarted = X_WC_last_.has_value();
  MakeKeyframe(view);
  return true;
}

/// Triangulates the start's inliers; the unit is such that their median depth is that of the map before (1 at first).
bool SiftVo::Tracker::BuildMap(View& view, const std::vector<Match>& matches, const std::vector<PointPair>& pairs,
                               const TwoView& two_view) {
  std::vector<std::pair<int, Eigen::Vector3d>> points;  // pair, point in the keyframe's camera frame
  std::vector<double> depths;
  for (const int i : two_view.inliers) {
    const std::vector<RayObservation> rays = {{Pose(), pairs[size_t(i)].a}, {two_view.X_AB, pairs[size_t(i)].b}};
    const auto p_A = TriangulatePoint(rays);
    if (!p_A || ParallaxAngle(*p_A, rays) < options_.min_parallax_deg * kRadPerDeg) continue;
    if (ReprojectionError(*p_A, rays[0]) > threshold_ || ReprojectionError(*p_A, rays[1]) > threshold_) continue;
    points.emplace_back(i, *p_A);
    depths.push_back(p_A->z());
  }
  if (int(points.size()) < options_.min_start_points) return false;
  const double unit = median_depth_ / Median(depths);
  keyframe_->X_WC = X_WC_last_.value_or(Pose());
  view.X_WC = keyframe_->X_WC * Pose(two_view.X_AB.rotation, unit * two_view.X_AB.translation);
  for (const auto& [i, p_A] : points) {
    const Match& match = matches[size_t(i)];
    view.point[size_t(match.b)] = int(map_.size());
    map_.push_back(
        {keyframe_->X_WC * (unit * p_A), {{keyframe_->X_WC, pairs[size_t(i)].a}, {view.X_WC, pairs[size_t(i)].b}}});
  }
  return true;
}

/// With a map: the pose from the keyframe's points that are seen again.
bool SiftVo::Tracker::Locate(View& view, FrameEstimate& answer) {
  matches_ = MatchWithKeyframe(view);
  std::vector<PointSighting> sightings;
  std::vector<int> feature, point;
  for (const Match& match : matches_) {
    const int p = keyframe_->point[size_t(match.a)];
    if (p < 0) continue;
    sightings.push_back({map_[size_t(p)].p_W, view.xy[size_t(match.b)]});
    feature.push_back(match.b);
    point.push_back(p);
  }
  const auto found = EstimateAbsolutePose(sightings, Ransacking(), random_, X_WC_last_);
  answer.inliers = int(found.inliers.size());
  if (answer.inliers < options_.min_matches) return false;
  view.X_WC = found.model;
  for (const int i : found.inliers) view.point[size_t(feature[size_t(i)])] = point[size_t(i)];
  return true;
}

bool SiftVo::Tracker::WantsKeyframe(const View& view) const {
  const int shared = PointsSeen(view);
  if (shared < options_.keyframe_overlap * keyframe_points_) return true;
  std::vector<double> angles;
  for (const int p : view.point) {
    if (p < 0) continue;
    const Eigen::Vector3d& p_W = map_[size_t(p)].p_W;
    angles.push_back(ParallaxAngle(p_W, {{keyframe_->X_WC, {}}, {view.X_WC, {}}}));
  }
  return Median(angles) > options_.keyframe_parallax_deg * kRadPerDeg;
}

/// The coming keyframe's rays sharpen the points it shares with the present one and make new points of other matches.
void SiftVo::Tracker::ExtendMap(View& view, const std::vector<Match>& matches) {
  const double min_parallax = options_.min_parallax_deg * kRadPerDeg;
  for (const Match& match : matches) {
    const RayObservation here = {view.X_WC, view.xy[size_t(match.b)]};
    const int known = view.point[size_t(match.b)];
    std::vector<RayObservation> rays;
    if (known >= 0) {
      rays = map_[size_t(known)].rays;
    } else if (keyframe_->point[size_t(match.a)] < 0) {
      rays = {{keyframe_->X_WC, keyframe_->xy[size_t(match.a)]}};
    } else {
      continue;  // the keyframe's point contradicts the pose: not the same thing
    }
    rays.push_back(here);
    if (rays.size() > kMostRays) rays.erase(rays.begin() + 1);
    const auto p_W = TriangulatePoint(rays);
    const bool good = p_W && ParallaxAngle(*p_W, rays) > min_parallax &&
                      std::all_of(rays.begin(), rays.end(),
                                  [&](const auto& ray) { return ReprojectionError(*p_W, ray) < threshold_; });
    if (!good) continue;
    if (known >= 0) {
      map_[size_t(known)] = {*p_W, rays};
    } else {
      view.point[size_t(match.b)] = int(map_.size());
      map_.push_back({*p_W, rays});
    }
  }
}

/// Frames are matched with `view` from now on; points that it does not show are forgotten.
void SiftVo::Tracker::MakeKeyframe(View view) {
  std::vector<MapPoint> kept;
  std::vector<double> depths;
  for (int& p : view.point) {
    if (p < 0) continue;
    kept.push_back(std::move(map_[size_t(p)]));
    p = int(kept.size()) - 1;
    depths.push_back((view.X_WC.Inverse() * kept.back().p_W).z());
  }
  map_ = std::move(kept);
  keyframe_points_ = int(map_.size());
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
