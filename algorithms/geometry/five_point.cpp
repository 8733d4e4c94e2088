#include "algorithms/geometry/five_point.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/core/small_solvers.h"
#include "algorithms/geometry/householder.h"
#include "algorithms/geometry/real_roots.h"

namespace gaitcam {
namespace {

// Polynomials in x, y, z; the order of a cubic's monomials is that of the elimination (paper, section 3.2): those on
// the left are eliminated, those on the right are x, y and 1 times powers of z.
using Linear = Eigen::Vector4d;                  ///< x, y, z, 1
using Quadratic = Eigen::Matrix<double, 10, 1>;  ///< xx, xy, xz, x, yy, yz, y, zz, z, 1
using Cubic = Eigen::Matrix<double, 20, 1>;  ///< xxx yyy xxy xyy xxz xx yyz yy xyz xy | xzz xz x yzz yz y zzz zz z 1
using Constraints = Eigen::Matrix<double, 10, 20>;

constexpr std::array<std::array<int, 4>, 4> kLinearTimesLinear = {
    {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}}};
constexpr std::array<std::array<int, 4>, 10> kQuadraticTimesLinear = {{{0, 2, 4, 5},        // xx
                                                                       {2, 3, 8, 9},        // xy
                                                                       {4, 8, 10, 11},      // xz
                                                                       {5, 9, 11, 12},      // x
                                                                       {3, 1, 6, 7},        // yy
                                                                       {8, 6, 13, 14},      // yz
                                                                       {9, 7, 14, 15},      // y
                                                                       {10, 13, 16, 17},    // zz
                                                                       {11, 14, 17, 18},    // z
                                                                       {12, 15, 18, 19}}};  // 1

void AddProduct(const Linear& p, const Linear& q, double sign, Quadratic& sum) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) sum[kLinearTimesLinear[size_t(i)][size_t(j)]] += sign * p[i] * q[j];
  }
}

void AddProduct(const Quadratic& p, const Linear& q, Cubic& sum) {
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 4; ++j) sum[kQuadraticTimesLinear[size_t(i)][size_t(j)]] += p[i] * q[j];
  }
}

/// The four matrices whose combinations x X + y Y + z Z + W satisfy b^T E a = 0 for all five pairs: entry (i, j) of E
/// as a linear polynomial.
std::array<std::array<Linear, 3>, 3> NullSpace(const std::vector<PointPair>& five) {
  Eigen::Matrix<double, 9, 5> A;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d a = five[size_t(k)].a.homogeneous(), b = five[size_t(k)].b.homogeneous();
    for (int i = 0; i < 3; ++i) A.col(k).segment<3>(3 * i) = b[i] * a;
  }
  Eigen::Matrix<double, 5, 1> tau;
  FactorQr(A, tau);
  Eigen::Matrix<double, 9, 4> basis = Eigen::Matrix<double, 9, 4>::Zero();
  basis.bottomRows<4>().setIdentity();
  MultiplyByQ(A, tau, basis);
  std::array<std::array<Linear, 3>, 3> E;
  for (int i = 0; i < 9; ++i) E[size_t(i / 3)][size_t(i % 3)] = basis.row(i);
  return E;
}

/// det E = 0 and E E^T E - tr(E E^T) E / 2 = 0: ten cubics (paper, equations 3 and 4).
Constraints CubicConstraints(const std::array<std::array<Linear, 3>, 3>& E) {
  std::array<std::array<Quadratic, 3>, 3> EEt;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = i; j < 3; ++j) {
      EEt[i][j].setZero();
      for (size_t k = 0; k < 3; ++k) AddProduct(E[i][k], E[j][k], 1, EEt[i][j]);
      EEt[j][i] = EEt[i][j];
    }
  }
  const Quadratic half_trace = 0.5 * (EEt[0][0] + EEt[1][1] + EEt[2][2]);
  for (size_t i = 0; i < 3; ++i) EEt[i][i] -= half_trace;
  Constraints constraints;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      Cubic sum = Cubic::Zero();
      for (size_t k = 0; k < 3; ++k) AddProduct(EEt[i][k], E[k][j], sum);
      constraints.row(long(3 * i + j)) = sum;
    }
  }
  Cubic determinant = Cubic::Zero();
  for (size_t j = 0; j < 3; ++j) {
    const size_t k = (j + 1) % 3, l = (j + 2) % 3;
    Quadratic minor = Quadratic::Zero();
    AddProduct(E[1][k], E[2][l], 1, minor);
    AddProduct(E[1][l], E[2][k], -1, minor);
    AddProduct(minor, E[0][j], determinant);
  }
  constraints.row(9) = determinant;
  return constraints;
}

/// B(z) (x, y, 1)^T = 0: entries of degree 3, 3 and 4 in z, the coefficient of z^0 first (paper, section 3.2.2).
using MatrixOfZ = std::array<std::array<std::array<double, 5>, 3>, 3>;

/// Rows <m z> - z <m> of the eliminated constraints, for m = xx, yy and xy.
MatrixOfZ EliminateToZ(const Eigen::Matrix<double, 10, 10>& rest) {
  MatrixOfZ B{};
  for (int r = 0; r < 3; ++r) {
    const auto with_z = rest.row(4 + 2 * r), without = rest.row(5 + 2 * r);
    for (int column = 0; column < 3; ++column) {
      const int first = 3 * column, count = column == 2 ? 4 : 3;  // powers of z, the highest first
      auto& polynomial = B[size_t(r)][size_t(column)];
      for (int k = 0; k < count; ++k) {
        polynomial[size_t(count - 1 - k)] += with_z[first + k];
        polynomial[size_t(count - k)] -= without[first + k];
      }
    }
  }
  return B;
}

/// Product of two polynomials, added to `sum` times `sign`.
template <size_t N, size_t M, size_t S>
void AddProduct(const std::array<double, N>& p, const std::array<double, M>& q, double sign,
                std::array<double, S>& sum) {
  for (size_t i = 0; i < N; ++i) {
    for (size_t j = 0; j < M; ++j) {
      if (i + j < S) sum[i + j] += sign * p[i] * q[j];
    }
  }
}

/// det B(z), of degree ten.
std::vector<double> Determinant(const MatrixOfZ& B) {
  std::array<double, 11> sum{};
  for (size_t j = 0; j < 3; ++j) {
    std::array<double, 9> minor{};
    AddProduct(B[1][(j + 1) % 3], B[2][(j + 2) % 3], 1, minor);
    AddProduct(B[1][(j + 2) % 3], B[2][(j + 1) % 3], -1, minor);
    AddProduct(minor, B[0][j], 1, sum);
  }
  return {sum.begin(), sum.end()};
}

/// (x, y, 1) spans the null space of B(z): the largest cross product of two of its rows.
Eigen::Vector3d NullVector(const MatrixOfZ& B, double z) {
  Eigen::Matrix3d M;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double value = 0;
      for (int k = 4; k >= 0; --k) value = value * z + B[size_t(i)][size_t(j)][size_t(k)];
      M(i, j) = value;
    }
    M.row(i).normalize();
  }
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d n = M.row(i).cross(M.row((i + 1) % 3));
    if (n.squaredNorm() > best.squaredNorm()) best = n;
  }
  return best;
}

/// The cubics' twenty monomials at (x, y, z), and their derivatives.
void Monomials(const Eigen::Vector3d& p, Cubic& m, Eigen::Matrix<double, 20, 3>& d) {
  const double x = p.x(), y = p.y(), z = p.z(), xx = x * x, yy = y * y, zz = z * z;
  m << xx * x, yy * y, xx * y, x * yy, xx * z, xx, yy * z, yy, x * y * z, x * y, x * zz, x * z, x, y * zz, y * z, y,
      zz * z, zz, z, 1;
  d.col(0) << 3 * xx, 0, 2 * x * y, yy, 2 * x * z, 2 * x, 0, 0, y * z, y, zz, z, 1, 0, 0, 0, 0, 0, 0, 0;
  d.col(1) << 0, 3 * yy, xx, 2 * x * y, 0, 0, 2 * y * z, 2 * y, x * z, x, 0, 0, 0, zz, z, 1, 0, 0, 0, 0;
  d.col(2) << 0, 0, 0, 0, xx, 0, yy, 0, x * y, 0, 2 * x * z, x, 0, 2 * y * z, y, 0, 3 * zz, 2 * z, 1, 0;
}

/// Gauss-Newton on the ten constraints, against the elimination's loss of precision.
void Polish(const Constraints& constraints, Eigen::Vector3d& p) {
  constexpr int kSteps = 2;
  Cubic m;
  Eigen::Matrix<double, 20, 3> d;
  for (int i = 0; i < kSteps; ++i) {
    Monomials(p, m, d);
    const Eigen::Matrix<double, 10, 1> residual = constraints * m;
    const Eigen::Matrix<double, 10, 3> J = constraints * d;
    const Eigen::Vector3d step = SolveSymmetric<3>(J.transpose() * J, J.transpose() * residual);
    constexpr double kMaxStep = 0.01;  // relative; more is no rounding error
    if (!step.allFinite() || !(step.norm() < kMaxStep * (1 + p.norm()))) return;
    p -= step;
  }
}

}  // namespace

std::vector<Eigen::Matrix3d> SolveFivePoint(const std::vector<PointPair>& five) {
  GAITCAM_ASSERT(five.size() == 5);
  const auto basis = NullSpace(five);
  const Constraints constraints = CubicConstraints(basis);
  const Eigen::Matrix<double, 10, 10> rest = SolveSquare(constraints.leftCols<10>(), constraints.rightCols<10>());
  std::vector<Eigen::Matrix3d> solutions;
  if (!rest.allFinite()) return solutions;
  const MatrixOfZ B = EliminateToZ(rest);
  for (const double z : RealRoots(Determinant(B))) {
    const Eigen::Vector3d xy1 = NullVector(B, z);
    Eigen::Vector3d xyz(xy1.x() / xy1.z(), xy1.y() / xy1.z(), z);
    if (!xyz.allFinite()) continue;
    Polish(constraints, xyz);
    const Eigen::Vector4d combination = xyz.homogeneous();
    Eigen::Matrix3d E;
    for (int i = 0; i < 9; ++i) E(i / 3, i % 3) = basis[size_t(i / 3)][size_t(i % 3)].dot(combination);
    E *= std::sqrt(2.0) / E.norm();
    if (E.allFinite()) solutions.push_back(E);
  }
  return solutions;
}

}  // namespace gaitcam
