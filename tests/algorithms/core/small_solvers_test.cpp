#include "algorithms/core/small_solvers.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

/// Random, of full rank or of one less.
template <int N>
SquareMatrix<N> Symmetric(RandomStream& random, bool singular) {
  SquareMatrix<N> R;
  for (int i = 0; i < N * N; ++i) R(i % N, i / N) = random.Normal();
  if (singular) R.col(N - 1).setZero();
  return R * R.transpose();
}

constexpr int kTrials = 200;

TEST(SmallSolvers, SolveSymmetricAsEigenDoesToTheBit) {
  RandomStream random(1, "small_solvers");
  for (int k = 0; k < kTrials; ++k) {
    const SquareMatrix<5> A = Symmetric<5>(random, k % 3 == 0);
    const ColumnVector<5> b = A.col(0) + ColumnVector<5>::Ones();
    EXPECT_EQ(SolveSymmetric(A, b), ColumnVector<5>(A.ldlt().solve(b)));
    const SquareMatrix<11> B = Symmetric<11>(random, k % 3 == 0);
    EXPECT_EQ(InverseOfSymmetric(B), SquareMatrix<11>(B.ldlt().solve(SquareMatrix<11>::Identity())));
  }
}

TEST(SmallSolvers, SmallestEigenvectorIsEigensToTheBit) {
  RandomStream random(2, "small_solvers");
  for (int k = 0; k < kTrials; ++k) {
    const SquareMatrix<9> A = Symmetric<9>(random, k % 3 == 0);
    EXPECT_EQ(SmallestEigenvector(A),
              ColumnVector<9>(Eigen::SelfAdjointEigenSolver<SquareMatrix<9>>(A).eigenvectors().col(0)));
  }
}

TEST(SmallSolvers, ZeroMatrixSolvesToZero) {
  const SquareMatrix<3> zero = SquareMatrix<3>::Zero();
  EXPECT_EQ(SolveSymmetric<3>(zero, Eigen::Vector3d::Ones()), Eigen::Vector3d(Eigen::Vector3d::Zero()));
}

}  // namespace
}  // namespace gaitcam
