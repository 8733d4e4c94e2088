/// A = Q R by Householder reflections I - tau v v^T with v = (1, essential part), for few columns (Golub and Van Loan
/// 2013, algorithm 5.2.1). Eigen's HouseholderQR takes the same steps; its variant for many columns, compiled with it,
/// takes the compiler several seconds.

#pragma once

#include <Eigen/Core>
#include <Eigen/Householder>

namespace gaitcam {

/// Leaves R in A's upper triangle and the essential parts below it.
template <class Matrix, class Vector>
void FactorQr(Matrix& A, Vector& tau) {
  Vector workspace(A.cols());
  for (Eigen::Index k = 0; k < A.cols(); ++k) {
    const Eigen::Index rows = A.rows() - k, cols_right = A.cols() - k - 1;
    double diagonal = 0;
    A.col(k).tail(rows).makeHouseholderInPlace(tau[k], diagonal);
    A(k, k) = diagonal;
    A.bottomRightCorner(rows, cols_right)
        .applyHouseholderOnTheLeft(A.col(k).tail(rows - 1), tau[k], workspace.data() + k + 1);
  }
}

/// M = Q M, for the Q of a factored A.
template <class Matrix, class Vector, class Other>
void MultiplyByQ(const Matrix& A, const Vector& tau, Other& M) {
  Eigen::Matrix<double, 1, Other::ColsAtCompileTime> workspace(M.cols());
  for (Eigen::Index k = A.cols() - 1; k >= 0; --k) {
    const Eigen::Index rows = A.rows() - k;
    M.bottomRightCorner(rows, M.cols()).applyHouseholderOnTheLeft(A.col(k).tail(rows - 1), tau[k], workspace.data());
  }
}

}  // namespace gaitcam
