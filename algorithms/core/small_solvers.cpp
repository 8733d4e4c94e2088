#include "algorithms/core/small_solvers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {

namespace {

/// P A P^T = L D L^T with diagonal pivoting (Golub and Van Loan 2013, section 4.2.8): D on the diagonal, L below it.
/// @param pivots the row that was exchanged with each row in turn.
void FactorSymmetric(Eigen::Ref<Eigen::MatrixXd> A, int* pivots) {
  constexpr int kMaxSize = 16;
  const int n = int(A.rows());
  GAITCAM_ASSERT(n <= kMaxSize);
  std::array<double, kMaxSize> d_l;  // row k of L times D
  for (int k = 0; k < n; ++k) {
    int p = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(A(i, i)) > std::abs(A(p, p))) p = i;
    }
    pivots[k] = p;
    if (p != k) {
      for (int j = 0; j < k; ++j) std::swap(A(k, j), A(p, j));
      for (int i = k + 1; i < p; ++i) std::swap(A(i, k), A(p, i));
      for (int i = p + 1; i < n; ++i) std::swap(A(i, k), A(i, p));
      std::swap(A(k, k), A(p, p));
    }
    for (int j = 0; j < k; ++j) d_l[size_t(j)] = A(j, j) * A(k, j);
    for (int i = k; i < n; ++i) {
      double sum = 0;
      for (int j = 0; j < k; ++j) sum += A(i, j) * d_l[size_t(j)];
      A(i, k) -= sum;
    }
    if (!(std::abs(A(k, k)) > 0)) continue;
    for (int i = k + 1; i < n; ++i) A(i, k) /= A(k, k);
  }
}

/// The X of A X = B. Rows of X whose pivot vanishes are 0 before L^T is solved for.
template <int N, class Matrix>
Matrix SolveByLdlt(SquareMatrix<N> A, Matrix X) {
  std::array<int, size_t(N)> pivots;
  FactorSymmetric(A, pivots.data());
  for (int k = 0; k < N; ++k) X.row(k).swap(X.row(pivots[size_t(k)]));
  // The triangular solves are Eigen's own, and so are the results those of its LDLT to the bit.
  A.template triangularView<Eigen::UnitLower>().solveInPlace(X);
  for (int k = 0; k < N; ++k) {
    if (std::abs(A(k, k)) > std::numeric_limits<double>::min()) {
      X.row(k) /= A(k, k);
    } else {
      X.row(k).setZero();
    }
  }
  A.transpose().template triangularView<Eigen::UnitUpper>().solveInPlace(X);
  for (int k = N; k-- > 0;) X.row(k).swap(X.row(pivots[size_t(k)]));
  return X;
}

}  // namespace

template <int N>
ColumnVector<N> SolveSymmetric(const SquareMatrix<N>& A, const ColumnVector<N>& b) {
  return SolveByLdlt(A, b);
}

template <int N>
SquareMatrix<N> InverseOfSymmetric(const SquareMatrix<N>& A) {
  return SolveByLdlt(A, SquareMatrix<N>(SquareMatrix<N>::Identity()));
}

template ColumnVector<3> SolveSymmetric(const SquareMatrix<3>&, const ColumnVector<3>&);
template ColumnVector<4> SolveSymmetric(const SquareMatrix<4>&, const ColumnVector<4>&);
template ColumnVector<5> SolveSymmetric(const SquareMatrix<5>&, const ColumnVector<5>&);
template ColumnVector<6> SolveSymmetric(const SquareMatrix<6>&, const ColumnVector<6>&);
template ColumnVector<11> SolveSymmetric(const SquareMatrix<11>&, const ColumnVector<11>&);
template SquareMatrix<3> InverseOfSymmetric(const SquareMatrix<3>&);
template SquareMatrix<4> InverseOfSymmetric(const SquareMatrix<4>&);
template SquareMatrix<6> InverseOfSymmetric(const SquareMatrix<6>&);
template SquareMatrix<11> InverseOfSymmetric(const SquareMatrix<11>&);

SquareMatrix<10> SolveSquare(const SquareMatrix<10>& A, const SquareMatrix<10>& B) {
  return Eigen::PartialPivLU<SquareMatrix<10>>(A).solve(B);
}

SquareMatrix<5> Inverse(const SquareMatrix<5>& A) { return A.inverse(); }

SymmetricEigen3 EigenOfSymmetric(const Eigen::Matrix3d& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

ColumnVector<4> SmallestEigenvector(const SquareMatrix<4>& A) {
  return Eigen::SelfAdjointEigenSolver<SquareMatrix<4>>(A).eigenvectors().col(0);
}

ColumnVector<9> SmallestEigenvector(const SquareMatrix<9>& A) {
  // SelfAdjointEigenSolver step by step: its Q, made for any size, takes the compiler several seconds.
  SquareMatrix<9> scaled = A.triangularView<Eigen::Lower>();
  const double scale = scaled.cwiseAbs().maxCoeff();
  if (scale != 0) scaled /= scale;
  const Eigen::Tridiagonalization<SquareMatrix<9>> T(scaled);  // Q T Q^T, Q a product of Householder reflections
  const SquareMatrix<9>& packed = T.packedMatrix();
  SquareMatrix<9> Q = SquareMatrix<9>::Identity();
  ColumnVector<9> workspace;
  for (int k = 7; k >= 0; --k) {
    Q.bottomRightCorner(8 - k, 8 - k)
        .applyHouseholderOnTheLeft(packed.col(k).tail(7 - k), T.householderCoefficients()[k], workspace.data());
  }
  ColumnVector<9> diagonal = packed.diagonal();
  ColumnVector<8> below = packed.diagonal<-1>();
  constexpr int kMaxSweeps = 30;
  Eigen::internal::computeFromTridiagonal_impl(diagonal, below, kMaxSweeps, true, Q);  // increasing eigenvalues
  return Q.col(0);
}

double Svd3::Handedness() const { return U.determinant() * V.determinant() < 0 ? -1 : 1; }

Eigen::Matrix3d Svd3::NearestRotation() const {
  return U * Eigen::Vector3d(1, 1, Handedness()).asDiagonal() * V.transpose();
}

Svd3 SvdOf(const Eigen::Matrix3d& A) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

}  // namespace gaitcam
