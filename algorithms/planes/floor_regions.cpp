#include "algorithms/planes/floor_regions.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "algorithms/core/small_solvers.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

bool Holds(const PutativePlane& plane, const Eigen::Vector2d& p) {
  const int u = int(p.x() + 0.5) - plane.at.x, v = int(p.y() + 0.5) - plane.at.y;
  return u >= 0 && v >= 0 && u < plane.at.width && v < plane.at.height && plane.pixels.at<uchar>(v, u) != 0;
}

/// The reference with the region's own points alone.
PlaneReference PartOf(const PlaneReference& whole, const PutativePlane& plane) {
  PlaneReference part{whole.pyramid, {}, whole.blur};
  for (size_t k = 0; k < whole.points.size(); ++k) {
    part.points.emplace_back();
    for (const Eigen::Vector2d& p : whole.points[k]) {
      if (Holds(plane, p * double(1 << k))) part.points.back().push_back(p);
    }
  }
  return part;
}

double MeanShift_px(const CameraModel& camera, const std::vector<Eigen::Vector2d>& points, const PlaneState& a,
                    const PlaneState& b) {
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector2d& p : points) {
    const auto at_a = WarpPixel(camera, a, p), at_b = WarpPixel(camera, b, p);
    if (!at_a || !at_b) continue;
    sum += (*at_a - *at_b).norm();
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

}  // namespace

std::vector<FloorRegion> JudgeRegions(const PlaneAligner& aligner, const CameraModel& camera,
                                      const PlaneReference& reference, const std::vector<PutativePlane>& planes,
                                      const ImagePyramid& current, const PlaneState& floor, const CurrentBlur& blur,
                                      const FloorRegionOptions& options) {
  PlanePrior prior;  // the motion is known from all regions, the region's own plane is not
  prior.distance_sigma = 0.5;
  prior.tilt_sigma_rad = 0.6;
  prior.translation_sigma_m = 0.01 / floor.normal_d.norm();
  prior.rotation_sigma_rad = 0.003;
  std::vector<FloorRegion> regions;
  for (const PutativePlane& plane : planes) {
    FloorRegion region;
    region.plane = plane;
    const PlaneReference part = PartOf(reference, plane);
    if (int(part.points.front().size()) >= options.min_points) {
      const PlaneAlignment own = aligner.Align(part, current, floor, prior, blur);
      const Eigen::Vector3d n = own.state.normal_d.normalized(), up = floor.normal_d.normalized();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - n * n.transpose();
      const Eigen::Matrix3d spread = across * own.normal_covariance * across / own.state.normal_d.squaredNorm();
      region.judged = own.inside_ratio >= aligner.options().min_inside_ratio;
      region.shift_px = MeanShift_px(camera, part.points.front(), own.state, floor);
      region.tilt_deg = kDegPerRad * std::acos(std::clamp(n.dot(up), -1.0, 1.0));
      region.tilt_sigma_deg = kDegPerRad * std::sqrt(std::max(0.0, EigenOfSymmetric(spread).values[2]));
      region.correlation = own.correlation;
      const bool leans = region.tilt_deg > options.max_tilt_deg + 3 * region.tilt_sigma_deg;
      region.is_floor = !region.judged || (region.shift_px <= options.max_shift_px && !leans &&
                                           region.correlation >= options.min_correlation);
    }
    regions.push_back(region);
  }
  return regions;
}

}  // namespace gaitcam
