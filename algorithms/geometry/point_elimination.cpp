#include "algorithms/geometry/point_elimination.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

namespace gaitcam {
namespace {

/// What damping adds to a diagonal.
template <class Diagonal>
auto Extra(const Diagonal& diagonal, double damping) {
  constexpr double kLeastCurvature = 1e-6;
  return (damping * diagonal.cwiseMax(kLeastCurvature)).eval();
}

/// Of a point that its images leave open along some directions, the inverse along the others: what is open does not
/// depend on the poses either.
Eigen::Matrix3d PseudoInverse(const Eigen::Matrix3d& H) {
  constexpr double kOpen = 1e-12;  // of the largest curvature
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(H);
  const Eigen::Vector3d inverse = axes.eigenvalues().unaryExpr(
      [&](double curvature) { return curvature > kOpen * axes.eigenvalues()[2] ? 1 / curvature : 0.0; });
  return axes.eigenvectors() * inverse.asDiagonal() * axes.eigenvectors().transpose();
}

/// Equations over the poses alone.
struct Reduced {
  Eigen::MatrixXd S;  ///< Schur's complement, the lower triangle.
  Eigen::VectorXd right;
  std::vector<Eigen::Matrix3d> inverses;  ///< Of the points' H.

  Reduced(const PosePointEquations& equations, double damping)
      : S(equations.H), right(-equations.g), inverses(equations.points.size()) {
    S.diagonal() += Extra(equations.H.diagonal(), damping);
    for (size_t i = 0; i < inverses.size(); ++i) {
      const EliminatedPoint& point = equations.points[i];
      Eigen::Matrix3d H = point.H;
      H.diagonal() += Extra(point.H.diagonal(), damping);
      inverses[i] = damping > 0 ? Eigen::Matrix3d(H.inverse()) : PseudoInverse(H);
      for (size_t a = 0; a < point.links.size(); ++a) {
        const PosePointLink& link = point.links[a];
        const Eigen::Matrix<double, 6, 3> W = link.H * inverses[i];
        right.segment<6>(6 * link.pose) += W * point.g;
        for (size_t b = 0; b <= a; ++b)
          S.block<6, 6>(6 * link.pose, 6 * point.links[b].pose).noalias() -= W * point.links[b].H.transpose();
      }
    }
  }
};

}  // namespace

PosePointLink* EliminatedPoint::Find(int pose) {
  const auto is_it = [&](const PosePointLink& link) { return link.pose == pose; };
  const auto link = std::find_if(links.begin(), links.end(), is_it);
  return link == links.end() ? nullptr : &*link;
}

PosePointEquations::PosePointEquations(std::vector<std::vector<int>> seen_by) : points(seen_by.size()) {
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<int>& poses = seen_by[i];
    std::sort(poses.begin(), poses.end());
    poses.erase(std::unique(poses.begin(), poses.end()), poses.end());
    for (const int pose : poses) {
      if (pose >= 0) points[i].links.push_back({pose, Eigen::Matrix<double, 6, 3>::Zero()});
    }
  }
}

void PosePointEquations::SetZero(int poses) {
  H = Eigen::MatrixXd::Zero(6 * poses, 6 * poses);
  g = Eigen::VectorXd::Zero(6 * poses);
  for (EliminatedPoint& point : points) {
    point.H.setZero();
    point.g.setZero();
    for (PosePointLink& link : point.links) link.H.setZero();
  }
}

std::optional<PosePointStep> SolvePosesAndPoints(const PosePointEquations& equations, double damping) {
  const Reduced reduced(equations, damping);
  const Eigen::LLT<Eigen::MatrixXd> factors(reduced.S);
  if (factors.info() != Eigen::Success) return {};
  PosePointStep step{factors.solve(reduced.right), {}, 0};
  const Eigen::VectorXd extra = Extra(equations.H.diagonal(), damping);
  step.gain = 0.5 * (step.poses.dot(extra.cwiseProduct(step.poses)) - equations.g.dot(step.poses));
  for (size_t i = 0; i < equations.points.size(); ++i) {
    const EliminatedPoint& point = equations.points[i];
    Eigen::Vector3d sum = point.g;
    for (const PosePointLink& link : point.links) sum += link.H.transpose() * step.poses.segment<6>(6 * link.pose);
    const Eigen::Vector3d change = -reduced.inverses[i] * sum;
    step.gain += 0.5 * (change.dot(Extra(point.H.diagonal(), damping).cwiseProduct(change)) - point.g.dot(change));
    step.points.push_back(change);
  }
  if (!step.poses.allFinite() || !(step.gain > 0)) return {};
  return step;
}

PosePointCovariances CovariancesOf(const PosePointEquations& equations) {
  Reduced reduced(equations, 0);
  PosePointCovariances covariances{{}, std::move(reduced.inverses)};
  const Eigen::LLT<Eigen::MatrixXd> factors(reduced.S);
  if (reduced.S.rows() == 0 || factors.info() != Eigen::Success) return covariances;
  const Eigen::MatrixXd poses = factors.solve(Eigen::MatrixXd::Identity(reduced.S.rows(), reduced.S.rows()));
  if (poses.allFinite()) covariances.poses = poses;
  return covariances;
}

}  // namespace gaitcam
