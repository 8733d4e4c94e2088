#include "algorithms/estimation/planar_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Residual of a relative pose, whitened.
struct Difference {
  PlanarPose motion;
  Eigen::Matrix3d root_information;

  template <class T>
  bool operator()(const T* from, const T* to, T* residual) const {
    using std::cos;
    using std::sin;
    const T x = to[0] - from[0], y = to[1] - from[1];
    // The difference in position in the frame of `from`, then in the measured frame of `to`.
    const T dx = cos(from[2]) * x + sin(from[2]) * y - motion.position.x();
    const T dy = -sin(from[2]) * x + cos(from[2]) * y - motion.position.y();
    const double c = cos(motion.heading), s = sin(motion.heading);
    const T turn = to[2] - from[2] - motion.heading;
    const Eigen::Matrix<T, 3, 1> off(c * dx + s * dy, -s * dx + c * dy, turn);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> whitened(residual);
    whitened = root_information.cast<T>() * off;
    return true;
  }
};

}  // namespace

/// To first order, the error of an edge is tau_to - Ad(X_to^-1 X_from) tau_from.
std::vector<Eigen::Matrix3d> PlanarGraphCovariances(const std::vector<PlanarPose>& solved,
                                                    const std::vector<PlanarEdge>& edges) {
  const Eigen::Index n = Eigen::Index(solved.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (const PlanarEdge& edge : edges) {
    const Eigen::Matrix3d W = edge.covariance.inverse();
    const Eigen::Matrix3d J = -PlanarAdjoint(solved[size_t(edge.to)].Inverse() * solved[size_t(edge.from)]);
    const Eigen::Index from = 3 * edge.from, to = 3 * edge.to;
    information.block<3, 3>(from, from) += J.transpose() * W * J;
    information.block<3, 3>(to, to) += W;
    information.block<3, 3>(from, to) += J.transpose() * W;
    information.block<3, 3>(to, from) += W * J;
  }
  std::vector<Eigen::Matrix3d> covariances(solved.size(), Eigen::Matrix3d::Zero());
  if (n < 2) return covariances;
  const Eigen::Index free = 3 * (n - 1);
  const Eigen::MatrixXd covariance =
      information.bottomRightCorner(free, free).ldlt().solve(Eigen::MatrixXd::Identity(free, free));
  for (Eigen::Index i = 1; i < n; ++i) covariances[size_t(i)] = covariance.block<3, 3>(3 * (i - 1), 3 * (i - 1));
  return covariances;
}

std::vector<PlanarPose> SolvePlanarGraph(const std::vector<PlanarPose>& start, const std::vector<PlanarEdge>& edges) {
  std::vector<std::array<double, 3>> poses;
  for (const PlanarPose& pose : start) poses.push_back({pose.position.x(), pose.position.y(), pose.heading});
  ceres::Problem problem;
  for (const PlanarEdge& edge : edges) {
    GAITCAM_ASSERT(edge.from >= 0 && edge.to >= 0 && size_t(std::max(edge.from, edge.to)) < start.size());
    const Eigen::Matrix3d root = Eigen::Matrix3d(edge.covariance.inverse()).llt().matrixU();
    Difference difference{edge.motion, root};
    // A loop closure measures heading modulo a full turn.
    const double turn = start[size_t(edge.to)].heading - start[size_t(edge.from)].heading;
    difference.motion.heading = turn + WrapAngle(edge.motion.heading - turn);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Difference, 3, 3, 3>(new Difference(difference)),
                             edge.may_be_wrong ? new ceres::CauchyLoss(3) : nullptr, poses[size_t(edge.from)].data(),
                             poses[size_t(edge.to)].data());
  }
  std::vector<PlanarPose> solved = start;
  if (edges.empty()) return solved;
  if (problem.HasParameterBlock(poses[0].data())) problem.SetParameterBlockConstant(poses[0].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;  // the same bits, whatever the machine
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return solved;
  for (size_t i = 0; i < poses.size(); ++i) solved[i] = {{poses[i][0], poses[i][1]}, poses[i][2]};
  return solved;
}

}  // namespace gaitcam
