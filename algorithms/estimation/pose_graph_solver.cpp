#include "algorithms/estimation/pose_graph_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

Vector6d ErrorOf(const GraphLink& link, const std::vector<GraphNode>& nodes) {
  const Pose& X_WF = nodes[size_t(link.from)].X_WC;
  const Pose& X_WT = nodes[size_t(link.to)].X_WC;
  return LogSe3(link.X_FT.Inverse() * (X_WF.Inverse() * X_WT));
}

double Chi2(const Vector6d& e, const Matrix6d& information) { return e.dot(information * e); }

/// Node 0 is held: it has no rows.
void AddBlock(int row, int column, const Matrix6d& block, Triplets& triplets) {
  if (row == 0 || column == 0) return;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) triplets.emplace_back(6 * (row - 1) + r, 6 * (column - 1) + c, block(r, c));
  }
}

/// How the error moves with its two poses.
struct LinkJacobians {
  Matrix6d from, to;

  LinkJacobians(const GraphLink& link, const std::vector<GraphNode>& nodes, const Vector6d& e) {
    const Pose X_TF = nodes[size_t(link.to)].X_WC.Inverse() * nodes[size_t(link.from)].X_WC;
    to = RightJacobianInverseSe3(e);
    from = -to * Adjoint(X_TF);
  }
};

class Problem {
 public:
  Problem(PoseGraph& graph, const PoseGraphOptions& options) : graph_(graph), options_(options) {
    for (const GraphLink& link : graph.links) {
      const int nodes = int(graph.nodes.size());
      GAITCAM_ASSERT(std::min(link.from, link.to) >= 0 && std::max(link.from, link.to) < nodes);
      information_.push_back(link.covariance.llt().solve(Matrix6d::Identity()));
    }
  }

  double Solve() {
    bool has_loops = false;
    for (GraphLink& link : graph_.links) {
      link.trust = 1;
      has_loops |= link.loop;
    }
    if (graph_.nodes.size() < 2 || graph_.links.empty()) return 0;
    Descend();
    if (has_loops) Graduate();
    return Cost();
  }

 private:
  /// Truncated least squares with a parameter mu that grows from convex on (Yang et al., section on their TLS).
  void Graduate() {
    constexpr double kStep = 1.4, kMostSteps = 200;
    double worst = 0;
    for (size_t l = 0; l < graph_.links.size(); ++l) {
      if (graph_.links[l].loop) worst = std::max(worst, Chi2Of(l));
    }
    const double c2 = options_.loop_chi2;
    if (worst <= c2) return;
    double mu = c2 / (2 * worst - c2);
    for (int i = 0; i < kMostSteps && !SetTrust(mu); ++i, mu *= kStep) Step();
    for (GraphLink& link : graph_.links) link.trust = link.trust < 0.5 ? 0 : 1;
    Descend();
    while (TakeBack()) Descend();
  }

  /// Where false loops pull as hard as true ones, all may have been given up on the way. The one that agrees best with
  /// what the others and the motions leave open is trusted again. @returns whether there was one.
  bool TakeBack() {
    const auto is_out = [](const GraphLink& link) { return link.loop && link.trust == 0; };
    if (std::none_of(graph_.links.begin(), graph_.links.end(), is_out)) return false;
    const PoseGraphCovariances covariances(graph_);
    GraphLink* best = nullptr;
    double least = options_.loop_chi2;
    for (GraphLink& link : graph_.links) {
      if (!is_out(link)) continue;
      const Pose expected = graph_.nodes[size_t(link.from)].X_WC.Inverse() * graph_.nodes[size_t(link.to)].X_WC;
      const double chi2 = InnovationChi2(expected, covariances.Between(link.from, link.to), link.X_FT, link.covariance);
      if (chi2 >= least) continue;
      least = chi2;
      best = &link;
    }
    if (best != nullptr) best->trust = 1;
    return best != nullptr;
  }

  /// @returns whether every loop is trusted fully or not at all.
  bool SetTrust(double mu) {
    bool decided = true;
    for (size_t l = 0; l < graph_.links.size(); ++l) {
      GraphLink& link = graph_.links[l];
      if (!link.loop) continue;
      const double relative = Chi2Of(l) / options_.loop_chi2;
      if (relative <= mu / (mu + 1)) {
        link.trust = 1;
      } else if (relative >= (mu + 1) / mu) {
        link.trust = 0;
      } else {
        link.trust = std::clamp(std::sqrt(mu * (mu + 1) / relative) - mu, 0.0, 1.0);
        decided = false;
      }
    }
    return decided;
  }

  void Descend() {
    for (int i = 0; i < options_.max_iterations; ++i) {
      if (Step() < 1e-9) return;
    }
  }

  double Chi2Of(size_t l) const { return Chi2(ErrorOf(graph_.links[l], graph_.nodes), information_[l]); }

  double Cost() const {
    double cost = 0;
    for (size_t l = 0; l < graph_.links.size(); ++l) cost += graph_.links[l].trust * Chi2Of(l);
    return cost;
  }

  /// One step of Gauss-Newton, damped until the cost does not rise. @returns the largest part of any tangent.
  double Step() {
    const Eigen::Index size = 6 * Eigen::Index(graph_.nodes.size() - 1);
    Triplets triplets;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (size_t l = 0; l < graph_.links.size(); ++l) AddLink(l, triplets, gradient);
    Sparse hessian(size, size);
    hessian.setFromTriplets(triplets.begin(), triplets.end());
    const std::vector<GraphNode> before = graph_.nodes;
    const double cost = Cost();
    constexpr double kTiny = 1e-12, kDamping = 1e-6, kLargest = 1e6;
    for (double damping = 0; damping < kLargest; damping = damping == 0 ? kDamping : 10 * damping) {
      Sparse damped = hessian;
      for (Eigen::Index i = 0; i < size; ++i) damped.coeffRef(i, i) += kTiny + damping * hessian.coeff(i, i);
      const Eigen::SimplicialLDLT<Sparse> solver(damped);
      if (solver.info() != Eigen::Success) continue;
      const Eigen::VectorXd step = -solver.solve(gradient);
      if (!step.allFinite()) continue;
      for (size_t n = 1; n < before.size(); ++n)
        graph_.nodes[n].X_WC = Plus(before[n].X_WC, step.segment<6>(6 * Eigen::Index(n - 1)));
      if (Cost() <= cost * (1 + 1e-12)) return step.lpNorm<Eigen::Infinity>();
    }
    graph_.nodes = before;
    return 0;
  }

  void AddLink(size_t l, Triplets& triplets, Eigen::VectorXd& gradient) const {
    const GraphLink& link = graph_.links[l];
    const Vector6d e = ErrorOf(link, graph_.nodes);
    const LinkJacobians J(link, graph_.nodes, e);
    const Matrix6d W = link.trust * information_[l];
    AddBlock(link.from, link.from, J.from.transpose() * W * J.from, triplets);
    AddBlock(link.to, link.to, J.to.transpose() * W * J.to, triplets);
    AddBlock(link.from, link.to, J.from.transpose() * W * J.to, triplets);
    AddBlock(link.to, link.from, J.to.transpose() * W * J.from, triplets);
    if (link.from > 0) gradient.segment<6>(6 * (link.from - 1)) += J.from.transpose() * W * e;
    if (link.to > 0) gradient.segment<6>(6 * (link.to - 1)) += J.to.transpose() * W * e;
  }

  PoseGraph& graph_;
  PoseGraphOptions options_;
  std::vector<Matrix6d> information_;  ///< Of each link.
};

}  // namespace

double SolvePoseGraph(PoseGraph& graph, const PoseGraphOptions& options) { return Problem(graph, options).Solve(); }

PoseGraphCovariances::PoseGraphCovariances(const PoseGraph& graph) : graph_(graph) {
  if (graph.nodes.size() < 2) return;
  Triplets triplets;
  for (const GraphLink& link : graph.links) {
    const LinkJacobians J(link, graph.nodes, ErrorOf(link, graph.nodes));
    const Matrix6d W = link.trust * link.covariance.llt().solve(Matrix6d::Identity());
    AddBlock(link.from, link.from, J.from.transpose() * W * J.from, triplets);
    AddBlock(link.to, link.to, J.to.transpose() * W * J.to, triplets);
    AddBlock(link.from, link.to, J.from.transpose() * W * J.to, triplets);
    AddBlock(link.to, link.from, J.to.transpose() * W * J.from, triplets);
  }
  const Eigen::Index size = 6 * Eigen::Index(graph.nodes.size() - 1);
  Sparse information(size, size);
  information.setFromTriplets(triplets.begin(), triplets.end());
  information_ = std::make_unique<Eigen::SimplicialLDLT<Sparse>>(information);
  GAITCAM_ASSERT(information_->info() == Eigen::Success);
}

PoseGraphCovariances::~PoseGraphCovariances() = default;

Eigen::MatrixXd PoseGraphCovariances::Columns(int node) const {
  const Eigen::Index size = 6 * Eigen::Index(graph_.nodes.size() - 1);
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(size, 6);
  unit.middleRows<6>(6 * (node - 1)).setIdentity();
  return information_->solve(unit);
}

Matrix6d PoseGraphCovariances::Of(int node) const {
  GAITCAM_ASSERT(node >= 0 && size_t(node) < graph_.nodes.size());
  if (node == 0) return Matrix6d::Zero();
  return Columns(node).middleRows<6>(6 * (node - 1));
}

Matrix6d PoseGraphCovariances::Between(int from, int to) const {
  GAITCAM_ASSERT(from >= 0 && size_t(from) < graph_.nodes.size());
  Matrix6d cross = Matrix6d::Zero();
  if (from > 0 && to > 0) cross = Columns(to).middleRows<6>(6 * (from - 1));
  const Pose X_FT = graph_.nodes[size_t(from)].X_WC.Inverse() * graph_.nodes[size_t(to)].X_WC;
  return CovarianceOfRelative(X_FT, Of(from), Of(to), cross);
}

std::vector<CommonErrors> PoseGraphCovariances::InCommon(const std::vector<CommonErrors>& of_links,
                                                         Eigen::Index errors) const {
  GAITCAM_ASSERT(of_links.size() == graph_.links.size());
  std::vector<CommonErrors> of_nodes(graph_.nodes.size(), CommonErrors::Zero(6, errors));
  if (graph_.nodes.size() < 2) return of_nodes;
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(6 * Eigen::Index(graph_.nodes.size() - 1), errors);
  for (size_t l = 0; l < graph_.links.size(); ++l) {
    const GraphLink& link = graph_.links[l];
    const Vector6d e = ErrorOf(link, graph_.nodes);
    const LinkJacobians J(link, graph_.nodes, e);
    // A motion that is off by Exp(d) leaves Log(Exp(-d) Exp(e)).
    const CommonErrors moved = link.trust * link.covariance.llt().solve(RightJacobianInverseSe3(-e) * of_links[l]);
    if (link.from > 0) pull.middleRows<6>(6 * (link.from - 1)) += J.from.transpose() * moved;
    if (link.to > 0) pull.middleRows<6>(6 * (link.to - 1)) += J.to.transpose() * moved;
  }
  const Eigen::MatrixXd moves = information_->solve(pull);
  for (size_t n = 1; n < of_nodes.size(); ++n) of_nodes[n] = moves.middleRows<6>(6 * Eigen::Index(n - 1));
  return of_nodes;
}

double InformationGain(const Matrix6d& expected, const Matrix6d& measured) {
  const auto log_det = [](const Matrix6d& m) { return m.ldlt().vectorD().array().abs().log().sum(); };
  return 0.5 * (log_det(expected + measured) - log_det(measured));
}

double InnovationChi2(const Pose& expected, const Matrix6d& expected_covariance, const Pose& measured,
                      const Matrix6d& measured_covariance) {
  // Both tangents are in the frame that X_FT maps from, which is the same to first order.
  const Vector6d e = Minus(measured, expected);
  const Eigen::LLT<Matrix6d> sum(expected_covariance + measured_covariance);
  if (sum.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return e.dot(sum.solve(e));
}

}  // namespace gaitcam
