/// Decompositions of small dense matrices, each compiled once: Eigen's templates take the compiler seconds per size in
/// every source that uses them.

#pragma once

#include <Eigen/Core>

namespace gaitcam {

template <int N>
using SquareMatrix = Eigen::Matrix<double, N, N>;
template <int N>
using ColumnVector = Eigen::Matrix<double, N, 1>;

/// The x of A x = b for a symmetric A, of which only the lower triangle is read, by L D L^T with pivoting.
/// N is 3, 4, 5, 6 or 11: others are to be added to the source.
template <int N>
ColumnVector<N> SolveSymmetric(const SquareMatrix<N>& A, const ColumnVector<N>& b);

/// A^-1, likewise. N is 3, 4, 6 or 11.
template <int N>
SquareMatrix<N> InverseOfSymmetric(const SquareMatrix<N>& A);

/// The X of A X = B, by L U with row pivoting.
SquareMatrix<10> SolveSquare(const SquareMatrix<10>& A, const SquareMatrix<10>& B);

/// A^-1, likewise.
SquareMatrix<5> Inverse(const SquareMatrix<5>& A);

/// A = V diag(values) V^T for a symmetric A, of which only the lower triangle is read.
struct SymmetricEigen3 {
  Eigen::Vector3d values;   ///< In increasing order.
  Eigen::Matrix3d vectors;  ///< V.
};
SymmetricEigen3 EigenOfSymmetric(const Eigen::Matrix3d& A);

/// The unit eigenvector of a symmetric A to the smallest eigenvalue; only the lower triangle of A is read.
ColumnVector<4> SmallestEigenvector(const SquareMatrix<4>& A);
ColumnVector<9> SmallestEigenvector(const SquareMatrix<9>& A);

/// A = U diag(values) V^T, by Jacobi rotations.
struct Svd3 {
  Eigen::Matrix3d U;
  Eigen::Vector3d values;  ///< In decreasing order.
  Eigen::Matrix3d V;
  /// 1, or -1 where U V^T is a reflection.
  double Handedness() const;
  /// The rotation R that maximises tr(R^T A): U V^T, with the last direction mirrored where that would be a reflection
  /// (S. Umeyama, IEEE PAMI 13(4), 1991, Eqs. 39, 40 and 43).
  Eigen::Matrix3d NearestRotation() const;
};
Svd3 SvdOf(const Eigen::Matrix3d& A);

}  // namespace gaitcam
