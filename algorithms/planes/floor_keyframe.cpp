#include "algorithms/planes/floor_keyframe.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace gaitcam {

double FloorKeyframe::FloorRatio() const {
  double floor = 0, all = 0;
  for (const FloorRegion& region : regions) {
    if (!region.judged || region.plane.kind != PutativePlane::Kind::kTexture) continue;
    all += region.plane.area_px;
    floor += region.is_floor ? region.plane.area_px : 0;
  }
  return all == 0 ? 1 : floor / all;
}

FloorKeyframe FloorReference::Retired() const {
  constexpr int kLevels = 3;  // pixels near the camera are finer than a map's cells
  FloorKeyframe retired;
  retired.id = id;
  retired.stamp_ns = stamp_ns;
  retired.image = ImagePyramid::Of(grey, kLevels);
  retired.floor = mask.clone();
  retired.X_WK = X_WK;
  retired.covariance = covariance;
  return retired;
}

PlaneState FloorPlaneState(const Pose& X_WC) {
  PlaneState state;
  state.normal_d = X_WC.rotation.conjugate() * -Eigen::Vector3d::UnitZ() / X_WC.translation.z();
  return state;
}

namespace {

/// The smallest rotation that turns one vector to the direction of another; of opposite ones, a half turn. Eigen's
/// FromTwoVectors is the same but for the axis of that half turn, for which it decomposes a matrix: that takes the
/// compiler several seconds.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  constexpr double kOpposite = -1 + 1e-12;
  if (cosine < kOpposite) return Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, a.unitOrthogonal()));
  const double twice_w = std::sqrt((1 + cosine) * 2);
  Eigen::Quaterniond q;
  q.vec() = a.cross(b) * (1 / twice_w);
  q.w() = twice_w * 0.5;
  return q;
}

}  // namespace

Pose Upright(const Pose& X_WC, const Eigen::Vector3d& up_C, double height) {
  const Eigen::Quaterniond fix = RotationBetween(X_WC.rotation * up_C, Eigen::Vector3d::UnitZ());
  const Eigen::Vector2d p = X_WC.translation.head<2>();
  return {fix * X_WC.rotation, {p.x(), p.y(), height}};
}

cv::Mat FloorMask(const CameraModel& camera, const Pose& X_WC, double range_heights) {
  cv::Mat mask(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(0));
  const Eigen::Vector3d n_d = FloorPlaneState(X_WC).normal_d;
  for (int v = 0; v < mask.rows; ++v) {
    uchar* row = mask.ptr<uchar>(v);
    for (int u = 0; u < mask.cols; ++u) {
      const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
      const double distance_heights = ray.norm() * n_d.norm() / std::max(1e-9, n_d.dot(ray));
      row[u] = n_d.dot(ray) > 0 && distance_heights < range_heights ? 255 : 0;
    }
  }
  return mask;
}

FloorKeyframe Retire(const FloorReference& reference, const PlaneAligner& aligner, const CameraModel& camera,
                     const ImagePyramid& image, const PlaneState& now, const CurrentBlur& blur,
                     const FloorRegionOptions& options) {
  FloorKeyframe retired = reference.Retired();
  retired.X_WK = Upright(reference.X_WK, -now.normal_d.normalized(), 1 / now.normal_d.norm());
  retired.regions = JudgeRegions(aligner, camera, reference.pixels, reference.regions, image, now, blur, options);
  for (const FloorRegion& region : retired.regions) {
    if (!region.is_floor) retired.floor(region.plane.at).setTo(0, region.plane.enclosed);
  }
  return retired;
}

cv::Mat WarpRejected(const FloorKeyframe& retired, const CameraModel& camera, const PlaneState& now) {
  cv::Mat rejected(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(0)), warped;
  bool any = false;
  for (const FloorRegion& region : retired.regions) {
    if (region.is_floor) continue;
    rejected(region.plane.at).setTo(255, region.plane.enclosed);
    any = true;
  }
  if (!any) return {};
  const Eigen::Matrix3d H = now.X_CR.R() + now.X_CR.translation * now.normal_d.transpose();
  const Eigen::Matrix3d G = camera.K() * H * camera.K().inverse();  // Eq. 6.5
  cv::Matx33d homography;
  for (int i = 0; i < 9; ++i) homography(i / 3, i % 3) = G(i / 3, i % 3);
  cv::warpPerspective(rejected, warped, homography, rejected.size(), cv::INTER_NEAREST);
  constexpr int kMargin_px = 6;
  cv::dilate(warped, warped, cv::getStructuringElement(cv::MORPH_RECT, {2 * kMargin_px + 1, 2 * kMargin_px + 1}));
  return warped;
}

}  // namespace gaitcam
