/// Least squares over a pose graph, robust to false loop closures, and the covariances of its solution.
///
/// The error of a link is e = Log(X_FT^-1 X_WF^-1 X_WT) in the tangent of se3.h, with the link's covariance. Loop
/// closures count with truncated least squares, reached by graduated non-convexity: at first all count, then those that
/// do not fit count less and less, and at the end a loop counts fully or not at all (H. Yang, P. Antonante, V. Tzoumas
/// and L. Carlone, "Graduated non-convexity for robust spatial perception", IEEE RA-L 5, 2020). A truncated loss at
/// once, from the motions' chain on, would reject true loops wherever the chain has drifted by more than a link's own
/// error.

#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "algorithms/core/pose_graph.h"

namespace gaitcam {

struct PoseGraphOptions {
  /// A loop closure whose squared Mahalanobis length is beyond this is false: the 99.9 % quantile of chi-square with
  /// six degrees of freedom.
  double loop_chi2 = 22.46;
  int max_iterations = 20;  ///< Of Gauss-Newton, where no loop's trust changes.
};

/// Moves the nodes to the minimum, the first one held, and sets the loops' trust. Covariances are left as they are.
/// Deterministic. Nodes that no link leads to stay where they are.
/// @returns the sum of squared Mahalanobis lengths, loops as they are trusted.
double SolvePoseGraph(PoseGraph& graph, const PoseGraphOptions& options = {});

/// Covariances at the solution of a graph, to first order: blocks of the inverse of its information.
class PoseGraphCovariances {
 public:
  /// @pre every node is linked with the first one.
  explicit PoseGraphCovariances(const PoseGraph& graph);
  ~PoseGraphCovariances();

  /// Of X_WC of a node; zero of the first.
  Matrix6d Of(int node) const;
  /// Of X_FT, the motion from one node to another.
  Matrix6d Between(int from, int to) const;
  /// What errors that many links have in common, a lens calibrated wrongly, do to each X_WC, to first order; zero to
  /// the first. Of a chain they are the links' own, carried on and added.
  /// @param of_links one for each link of the graph, in its order: 6 x errors, the tangent of X_FT (m, rad) that one
  /// standard deviation of each error makes.
  /// @returns for each node the same of X_WC.
  std::vector<CommonErrors> InCommon(const std::vector<CommonErrors>& of_links, Eigen::Index errors) const;

 private:
  /// Covariances of all nodes with this one: 6 columns.
  Eigen::MatrixXd Columns(int node) const;

  PoseGraph graph_;
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> information_;  ///< Null for a single node.
};

/// What a measurement of X_FT tells that the graph does not know, in nats: half the logarithm of det(S) over
/// det(measured), S being the covariance of the difference between what is expected and what is measured
/// (V. Ila, J. M. Porta and J. Andrade-Cetto, "Information-based compact Pose SLAM", IEEE T-RO 26, 2010).
/// @param expected covariance of X_FT as the graph has it.
double InformationGain(const Matrix6d& expected, const Matrix6d& measured);

/// Squared Mahalanobis length of the difference between an expected and a measured X_FT: chi-square with six degrees of
/// freedom if both are right. Infinity if the covariances' sum is not positive definite.
double InnovationChi2(const Pose& expected, const Matrix6d& expected_covariance, const Pose& measured,
                      const Matrix6d& measured_covariance);

}  // namespace gaitcam
