/// Stereo rigs and points in their view.

#pragma once

#include "algorithms/core/random.h"
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

}  // namespace gaitcam
