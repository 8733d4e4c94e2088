/// Epipolar geometry of two calibrated views.

#pragma once

#include <Eigen/Geometry>
#include <limits>

namespace gaitcam {

/// One point in two images, in normalised coordinates (undistorted, focal length 1).
struct PointPair {
  Eigen::Vector2d a, b;
};

/// First-order geometric error of a pair: its distance from the nearest pair that satisfies the epipolar constraint
/// b^T E a = 0 (Sampson; Hartley and Zisserman 2003, equation 11.9), squared.
inline double SampsonError2(const Eigen::Matrix3d& E, const PointPair& pair) {
  const double ax = pair.a.x(), ay = pair.a.y(), bx = pair.b.x(), by = pair.b.y();
  const double u = E(0, 0) * ax + E(0, 1) * ay + E(0, 2), v = E(1, 0) * ax + E(1, 1) * ay + E(1, 2);
  const double s = E(0, 0) * bx + E(1, 0) * by + E(2, 0), t = E(0, 1) * bx + E(1, 1) * by + E(2, 1);
  const double algebraic = bx * u + by * v + E(2, 0) * ax + E(2, 1) * ay + E(2, 2);
  const double gradient2 = u * u + v * v + s * s + t * t;
  return gradient2 > 0 ? algebraic * algebraic / gradient2 : std::numeric_limits<double>::infinity();
}

/// Distance of b from the epipolar line E a in the second image, squared: the error of thesis 5.4, step 4.
inline double EpipolarDistance2(const Eigen::Matrix3d& E, const PointPair& pair) {
  const Eigen::Vector3d line = E * pair.a.homogeneous();
  const double algebraic = line.x() * pair.b.x() + line.y() * pair.b.y() + line.z();
  const double gradient2 = line.x() * line.x() + line.y() * line.y();
  return gradient2 > 0 ? algebraic * algebraic / gradient2 : std::numeric_limits<double>::infinity();
}

}  // namespace gaitcam
