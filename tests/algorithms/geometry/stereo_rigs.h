/// Stereo rigs and points in their view.

#pragma once

#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/geometry/error_propagation.h"
#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// The chapter's rig (Valencia, section 2.3.3.1) with an ideal lens.
inline StereoRig ChapterRig() {
  const CameraModel camera = CameraModel::FromHorizontalFov(640, 480, 60);
  return {camera, camera, Pose(RotZ(0.014) * RotY(0.016) * RotX(0.040), {0.385, 0.007, 0})};
}

/// Two different cameras with barrel and tangential distortion, pixels that are not square, turned about each axis.
inline StereoRig DistortedRig() {
  StereoRig rig = ChapterRig();
  rig.X_LR = Pose(RotX(-0.05) * RotY(-0.1) * RotZ(0.08), {0.12, -0.01, 0.02});
  rig.left.k1 = -0.2;
  rig.left.k2 = 0.04;
  rig.left.p1 = 0.001;
  rig.left.p2 = -0.002;
  rig.right = CameraModel::FromHorizontalFov(800, 600, 70);
  rig.right.fy *= 1.1;
  rig.right.cx += 7;
  rig.right.k1 = -0.15;
  rig.right.k2 = 0.03;
  return rig;
}

inline StereoSighting SeenBy(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  StereoSighting sighting;
  sighting.left = *rig.left.Project(p_L);
  sighting.right = *rig.right.Project(rig.X_LR.Inverse() * p_L);
  return sighting;
}

inline bool InView(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  const auto left = rig.left.Project(p_L), right = rig.right.Project(rig.X_LR.Inverse() * p_L);
  return left && right && rig.left.Contains(*left) && rig.right.Contains(*right);
}

/// Uniform in the left image and in depth, m, of what both cameras see.
inline Eigen::Vector3d PointInView(const StereoRig& rig, double near, double far, RandomStream& random) {
  for (;;) {
    const Eigen::Vector2d pixel(random.Uniform(0, rig.left.width_px - 1), random.Uniform(0, rig.left.height_px - 1));
    const Eigen::Vector3d p_L = random.Uniform(near, far) * rig.left.Unproject(pixel);
    if (InView(rig, p_L)) return p_L;
  }
}

/// Pixels of both pairs of a rig that moved.
struct TwoPairs {
  StereoRig rig;
  Pose X_AB;
  std::vector<StereoSighting> A, B;

  /// Points between these depths in B, which the step brings nearer in A.
  TwoPairs(const StereoRig& the_rig, int count, double sigma_px, double forward_m, RandomStream& random,
           double near = 2, double far = 8)
      : rig(the_rig), X_AB(ExpSo3({0.01, 0.03, -0.02}), {0.03, 0.01, -forward_m}) {
    while (int(A.size()) < count) {
      const Eigen::Vector3d p_B = PointInView(rig, near, far, random);
      if (!InView(rig, X_AB * p_B)) continue;
      B.push_back(SeenBy(rig, p_B));
      A.push_back(SeenBy(rig, X_AB * p_B));
      for (StereoSighting* seen : {&A.back(), &B.back()})
        seen->covariance_left = seen->covariance_right *= sigma_px * sigma_px;
    }
  }
  /// With errors of that standard deviation.
  TwoPairs Noisy(double sigma_px, RandomStream& random) const {
    TwoPairs noisy = *this;
    for (auto* sightings : {&noisy.A, &noisy.B})
      for (StereoSighting& seen : *sightings)
        for (Eigen::Vector2d* pixel : {&seen.left, &seen.right})
          *pixel += sigma_px * Eigen::Vector2d(random.Normal(), random.Normal());
    return noisy;
  }
  std::vector<StereoPointMatch> Points(double sigma_px, RandomStream& random,
                                       StereoCost cost = StereoCost::kAlgebraic) const {
    const TwoPairs noisy = Noisy(sigma_px, random);
    std::vector<StereoPointMatch> points;
    for (size_t k = 0; k < A.size(); ++k)
      points.push_back({ReconstructPoint(rig, noisy.A[k], {cost, 0}), ReconstructPoint(rig, noisy.B[k], {cost, 0})});
    return points;
  }
};

inline std::vector<PointMatch> MatchesOf(const std::vector<StereoPointMatch>& points) {
  std::vector<PointMatch> matches;
  for (const StereoPointMatch& point : points) matches.push_back(point.Match());
  return matches;
}

}  // namespace gaitcam
