#include "algorithms/odometry/stereo_view.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <tuple>

#include "algorithms/core/errors.h"
#include "algorithms/features/matching.h"
#include "algorithms/odometry/feature_search.h"

namespace gaitcam {
namespace {

/// Copies of a key point that differ in nothing but their orientation have one and the same error: the strongest stays.
Features OnePerPlace(const Features& all) {
  Features kept;
  std::set<std::tuple<float, float, float>> places;
  for (int i = 0; i < all.size(); ++i) {
    const cv::KeyPoint& keypoint = all.keypoints[size_t(i)];
    if (!places.emplace(keypoint.pt.x, keypoint.pt.y, keypoint.size).second) continue;
    kept.keypoints.push_back(keypoint);
    kept.descriptors.push_back(all.descriptors.row(i));
  }
  return kept;
}

/// Both images turned so that the right camera lies along x, as rectification does: partners have equal y there.
class RectifiedRows {
 public:
  RectifiedRows(const StereoRig& rig, const CameraFeatures& left, const CameraFeatures& right) {
    const Eigen::Vector3d x = rig.X_LR.translation.normalized();
    const Eigen::Vector3d y = Eigen::Vector3d::UnitZ().cross(x).normalized();
    Eigen::Matrix3d R;  // from the left camera
    R << x.transpose(), y.transpose(), x.cross(y).transpose();
    left_ = Turned(R, left.xy);
    right_ = Turned(R * rig.X_LR.R(), right.xy);
    order_.resize(right_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](int a, int b) { return right_[size_t(a)].y() < right_[size_t(b)].y(); });
  }

  /// Right features on the line of a left one, within `band` of it, and at most `most` to its left.
  void Candidates(size_t i, double band, double most, std::vector<int>& candidates) const {
    candidates.clear();
    const Eigen::Vector2d& p = left_[i];
    const auto first = std::lower_bound(order_.begin(), order_.end(), p.y() - band,
                                        [&](int a, double y) { return right_[size_t(a)].y() < y; });
    for (auto at = first; at != order_.end() && right_[size_t(*at)].y() <= p.y() + band; ++at) {
      const double disparity = p.x() - right_[size_t(*at)].x();
      if (disparity > -band && disparity < most) candidates.push_back(*at);
    }
  }

 private:
  static std::vector<Eigen::Vector2d> Turned(const Eigen::Matrix3d& R, const std::vector<Eigen::Vector2d>& xy) {
    std::vector<Eigen::Vector2d> turned;
    for (const Eigen::Vector2d& p : xy) turned.push_back((R * p.homogeneous()).hnormalized());
    return turned;
  }

  std::vector<Eigen::Vector2d> left_, right_;
  std::vector<int> order_;  ///< Right features by y.
};

}  // namespace

StereoSighting StereoView::Sighting(size_t i) const {
  const size_t r = size_t(partner[i]);
  return {left.pixel[i], right.pixel[r], left.covariance_px[i], right.covariance_px[r]};
}

RigSighting StereoView::SightingOf(size_t i, const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance_W) const {
  RigSighting sighting{p_W, covariance_W, left.xy[i], left.covariance[i]};
  if (partner[i] < 0) return sighting;
  const size_t r = size_t(partner[i]);
  sighting.has_right = true;
  sighting.right = right.xy[r];
  sighting.covariance_right = right.covariance[r];
  return sighting;
}

std::vector<StereoSighting> StereoView::Sightings() const {
  std::vector<StereoSighting> sightings;
  for (size_t i = 0; i < left.size(); ++i) {
    if (partner[i] >= 0) sightings.push_back(Sighting(i));
  }
  return sightings;
}

CameraFeatures DetectInCamera(const cv::Mat& image, const CameraModel& camera, const std::string& which,
                              cv::Feature2D& detector, int max_features) {
  if (image.cols != camera.width_px || image.rows != camera.height_px) {
    throw BadInput("the " + which + " image has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera.width_px) + " x " +
                   std::to_string(camera.height_px));
  }
  CameraFeatures found;
  found.features = OnePerPlace(DetectFeatures(detector, image, max_features));
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const double noise = ImageNoise(grey);
  for (const cv::KeyPoint& keypoint : found.features.keypoints) {
    found.pixel.emplace_back(keypoint.pt.x, keypoint.pt.y);
    found.noise_px.push_back(NoiseBound(grey, keypoint, noise));
    found.xy.push_back(camera.Unproject(found.pixel.back()).head<2>());
  }
  return found;
}

bool IsPair(const Observation& observation, bool is_first) {
  constexpr int64_t kSameInstant_ns = 1'000'000;
  std::string wrong;
  if (!observation.right) {
    wrong = "there is no right image";
  } else if (std::abs(observation.right->stamp_ns - observation.image.stamp_ns) > kSameInstant_ns) {
    wrong = "the right image's stamp is " + std::to_string(observation.right->stamp_ns - observation.image.stamp_ns) +
            " ns after the left one's; a stereo pair is of one instant, within 1000000 ns";
  }
  if (!wrong.empty() && is_first) throw BadInput("the first frame: " + wrong);
  return wrong.empty();
}

StereoView DetectInBoth(const Observation& observation, const StereoRig& rig, cv::Feature2D& detector,
                        int max_features) {
  StereoView view;
  view.left = DetectInCamera(observation.image.pixels, rig.left, "left", detector, max_features);
  view.right = DetectInCamera(observation.right->pixels, rig.right, "right", detector, max_features);
  return view;
}

void RefuseSwapped(const StereoRig& rig, const StereoView& view) {
  if (view.left.size() == 0 || view.right.size() == 0) return;
  std::vector<StereoSighting> sightings;
  for (const Match& match : MatchDescriptors(view.left.features.descriptors, view.right.features.descriptors, {})) {
    const size_t l = size_t(match.a), r = size_t(match.b);
    sightings.push_back(
        {view.left.pixel[l], view.right.pixel[r], view.left.covariance_px[l], view.right.covariance_px[r]});
  }
  if (TellImageOrder(rig, sightings) == ImageOrder::kSwapped) {
    throw BadInput(
        "the first frame: left and right images are swapped: the right camera, which the calibration puts to the "
        "right, "
        "sees most points further right");
  }
}

ImageMotion ImageMotion::Of(const Pose& X_TO) const {
  ImageMotion other = *this;
  const auto carry = [&X_TO](std::vector<Pose>& poses) {
    for (Pose& X_TM : poses) X_TM = X_TO.Inverse() * X_TM * X_TO;
  };
  for (std::vector<Pose>& exposure : other.exposures) carry(exposure);
  carry(other.readout);
  return other;
}

const std::vector<Pose>& ImageMotion::ExposureAt(const CameraModel& camera, double y_px) const {
  static const std::vector<Pose> kNone;
  if (exposures.empty()) return kNone;
  const double share = std::clamp(y_px / std::max(1.0, camera.height_px - 1.0), 0.0, 1.0);
  return exposures[size_t(std::lround(share * double(exposures.size() - 1)))];
}

void UndoMotion(const CameraModel& camera, const ImageMotion& motion, const std::vector<double>& inverse_depths,
                const KeypointNoiseOptions& noise, CameraFeatures& features) {
  const Eigen::Matrix2d per_focal = Eigen::Vector2d(1 / camera.fx, 1 / camera.fy).asDiagonal();
  features.covariance_px.clear();
  features.covariance.clear();
  for (size_t i = 0; i < features.size(); ++i) {
    const cv::KeyPoint& keypoint = features.features.keypoints[i];
    const double inverse_depth = inverse_depths.empty() ? 0 : inverse_depths[i];
    const Eigen::Vector2d seen(keypoint.pt.x, keypoint.pt.y);
    const std::vector<Pose>& exposure = motion.ExposureAt(camera, seen.y());
    const Eigen::Matrix2d spread = BlurSpread(camera, exposure, seen, inverse_depth);
    Eigen::Vector2d pixel =
        seen - BlurOffset(camera, exposure, seen, inverse_depth, noise.offset_scale * keypoint.size);
    pixel -= RowOffset(camera, motion.readout, pixel, inverse_depth);
    features.pixel[i] = pixel;
    features.xy[i] = camera.Unproject(pixel).head<2>();
    features.covariance_px.push_back(KeypointCovariance(keypoint, spread, features.noise_px[i], noise));
    const Eigen::Matrix2d J = camera.DistortionJacobian(features.xy[i]).inverse() * per_focal;
    features.covariance.push_back(J * features.covariance_px.back() * J.transpose());
  }
}

std::vector<double> InverseDepths(const StereoRig& rig, const StereoView& view) {
  std::vector<double> inverse_depths(view.left.size(), 0);
  std::vector<size_t> known;
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (view.partner[i] < 0) continue;
    const StereoPoint point = ReconstructPoint(rig, view.Sighting(i));
    if (!point.ok()) continue;
    inverse_depths[i] = 1 / point.p_L.z();
    known.push_back(i);
  }
  if (known.empty()) return {};
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (inverse_depths[i] > 0) continue;
    const auto distance2 = [&](size_t k) { return (view.left.pixel[k] - view.left.pixel[i]).squaredNorm(); };
    inverse_depths[i] = inverse_depths[*std::min_element(
        known.begin(), known.end(), [&](size_t a, size_t b) { return distance2(a) < distance2(b); })];
  }
  return inverse_depths;
}

std::vector<int> MatchStereo(const StereoRig& rig, const CameraFeatures& left, const CameraFeatures& right,
                             const StereoMatchingOptions& options) {
  const RectifiedRows rows(rig, left, right);
  const double most = rig.X_LR.translation.norm() / options.least_distance_m;
  DescriptorSearch search(right.xy, right.features.descriptors, options.stereo_ratio, 2 / rig.left.fx);
  std::vector<NearestFeature> claims(right.size());  // by the left features
  std::vector<int> candidates;
  for (size_t i = 0; i < left.size(); ++i) {
    const double sigma_px = std::sqrt(0.5 * left.covariance_px[i].trace());
    rows.Candidates(i, (options.epipolar_px + options.epipolar_sigmas * sigma_px) / rig.left.fx, most, candidates);
    const NearestFeature found = search.Find(left.features.descriptors.row(int(i)), cv::Mat(), candidates);
    if (found.feature < 0) continue;
    NearestFeature& claim = claims[size_t(found.feature)];
    if (found.distance < claim.distance) claim = {int(i), found.distance};
  }
  std::vector<int> partner(left.size(), -1);
  for (size_t r = 0; r < claims.size(); ++r) {
    if (claims[r].feature >= 0) partner[size_t(claims[r].feature)] = int(r);
  }
  return partner;
}

}  // namespace gaitcam
