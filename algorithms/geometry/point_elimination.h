/// Normal equations over poses and points, solved by eliminating the points first: Schur's complement (B. Triggs,
/// P. McLauchlan, R. Hartley and A. Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000, section 6.1).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace gaitcam {

/// What a point and one of the poses that it depends on have in common.
struct PosePointLink {
  int pose = 0;
  Eigen::Matrix<double, 6, 3> H;
};

/// A point's part of the equations.
struct EliminatedPoint {
  std::vector<PosePointLink> links;  ///< By increasing pose.
  Eigen::Matrix3d H;
  Eigen::Vector3d g;

  /// Null where the point does not depend on the pose.
  PosePointLink* Find(int pose);
};

/// Sum of squares to second order: 1/2 x' H x + g' x over all changes x. Three unknowns a point, six a pose.
struct PosePointEquations {
  Eigen::MatrixXd H;  ///< Of the poses; its lower triangle.
  Eigen::VectorXd g;
  std::vector<EliminatedPoint> points;

  PosePointEquations() = default;
  /// @param seen_by of each point the poses that it depends on; negative ones are fixed, repetitions do not matter.
  explicit PosePointEquations(std::vector<std::vector<int>> seen_by);
  void SetZero(int poses);
};

/// A change of all unknowns, and by how much the linearised problem's cost falls with it.
struct PosePointStep {
  Eigen::VectorXd poses;
  std::vector<Eigen::Vector3d> points;
  double gain = 0;
};

/// The step with each unknown's curvature enlarged by this part; nothing where that is singular.
std::optional<PosePointStep> SolvePosesAndPoints(const PosePointEquations& equations, double damping);

/// Covariances at the minimum, where residuals have unit variance.
struct PosePointCovariances {
  Eigen::MatrixXd poses;                ///< The points' errors included; empty where the equations are singular.
  std::vector<Eigen::Matrix3d> points;  ///< The poses held fixed. Singular: its images leave the point open.
};
PosePointCovariances CovariancesOf(const PosePointEquations& equations);

}  // namespace gaitcam
