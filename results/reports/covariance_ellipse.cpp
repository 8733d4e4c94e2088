#include "results/reports/covariance_ellipse.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "algorithms/core/median.h"

namespace gaitcam::internal {

using Eigen::Matrix3d;
using Eigen::Vector2d;

PositionEllipse EllipseOf(const Eigen::Quaterniond& R_WC, const Matrix6d& covariance) {
  const double k95 = std::sqrt(5.991);  // chi-square of two degrees of freedom
  const Matrix3d R = R_WC.toRotationMatrix();
  const Matrix3d in_world = R * covariance.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(Eigen::Matrix2d(in_world.topLeftCorner<2, 2>()));
  const Vector2d major = axes.eigenvectors().col(1);
  return {k95 * axes.eigenvalues().cwiseMax(0).cwiseSqrt().reverse(), std::atan2(major.y(), major.x())};
}

double EllipseMagnification(const std::vector<PositionEllipse>& ellipses, double unit_m) {
  constexpr double kVisible = 2;  // in units of the drawing
  std::vector<double> majors;
  for (const PositionEllipse& ellipse : ellipses) majors.push_back(ellipse.axes_m.x());
  const double median_m = majors.empty() ? 0 : UpperMedian(std::move(majors));
  double magnification = 1;
  if (median_m <= 0) return magnification;
  for (int step = 0; magnification * median_m < kVisible * unit_m; ++step) magnification *= step % 3 == 1 ? 2.5 : 2;
  return magnification;  // 1, 2, 5, 10, ...
}

}  // namespace gaitcam::internal
