#include "algorithms/core/planar_pose.h"

#include <cmath>

namespace gaitcam {

Eigen::Vector2d Rotate(const Eigen::Vector2d& v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

PlanarPose PlanarPose::Inverse() const { return {-Rotate(position, -heading), -heading}; }

Pose PlanarPose::Lifted(double z) const { return {RotZ(heading), Eigen::Vector3d(position.x(), position.y(), z)}; }

PlanarPose operator*(const PlanarPose& X_AB, const PlanarPose& X_BC) {
  return {X_AB * X_BC.position, X_AB.heading + X_BC.heading};
}

Eigen::Vector2d operator*(const PlanarPose& X_AB, const Eigen::Vector2d& p_B) {
  return X_AB.position + Rotate(p_B, X_AB.heading);
}

PlanarMotion::PlanarMotion(const PlanarPose& X_AB)
    : position_(X_AB.position), c_(std::cos(X_AB.heading)), s_(std::sin(X_AB.heading)) {}

PlanarPose BelowCamera(const Pose& X_WC) {
  const Eigen::Vector3d forward = X_WC.rotation * Eigen::Vector3d::UnitZ();
  return {X_WC.translation.head<2>(), std::atan2(forward.y(), forward.x())};
}

Eigen::Matrix3d PlanarAdjoint(const PlanarPose& X_AB) {
  Eigen::Matrix3d adjoint = RotZ(X_AB.heading);
  adjoint.topRightCorner<2, 1>() = Eigen::Vector2d(X_AB.position.y(), -X_AB.position.x());
  return adjoint;
}

Eigen::Matrix3d PlanarCovariance(const Pose& X_WC, const Matrix6d& covariance) {
  const Eigen::Matrix3d R_PC = RotZ(-BelowCamera(X_WC).heading) * X_WC.R();
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  J.topLeftCorner<2, 3>() = R_PC.topRows<2>();
  J.bottomRightCorner<1, 3>() = R_PC.row(2);
  return J * covariance * J.transpose();
}

Matrix6d SpatialCovariance(const Pose& X_WC, const Eigen::Matrix3d& planar, double height_sigma, double tilt_sigma) {
  Matrix6d in_P = Matrix6d::Zero();  // in the axes of the frame below the camera
  in_P.topLeftCorner<2, 2>() = planar.topLeftCorner<2, 2>();
  in_P.topRightCorner<2, 1>() = planar.topRightCorner<2, 1>();
  in_P.bottomLeftCorner<1, 2>() = planar.bottomLeftCorner<1, 2>();
  in_P(5, 5) = planar(2, 2);
  in_P(2, 2) = height_sigma * height_sigma;
  in_P(3, 3) = in_P(4, 4) = tilt_sigma * tilt_sigma;
  const Eigen::Matrix3d R_CP = X_WC.R().transpose() * RotZ(BelowCamera(X_WC).heading);
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = J.bottomRightCorner<3, 3>() = R_CP;
  return J * in_P * J.transpose();
}

}  // namespace gaitcam
