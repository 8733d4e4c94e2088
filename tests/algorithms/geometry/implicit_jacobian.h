/// The implicit function theorem by automatic differentiation, to compare closed forms with.

#pragma once

#include <ceres/jet.h>

#include <Eigen/Dense>
#include <array>

namespace gaitcam {

/// A constant among jets of jets, which know no conversion from double.
template <class JetOfJets>
JetOfJets Number(double value) {
  return JetOfJets(decltype(JetOfJets::a)(value));
}

/// dy/dx where y minimises C(x, y) (Valencia, Eq. 2.23), all second derivatives by jets of jets.
/// @param cost  (const std::array<T, X + Y>&) -> T for jets of jets T, constants by Number<T>(); x first, then y
template <int X, int Y, class Cost>
Eigen::MatrixXd ImplicitJacobian(const Cost& cost, const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  using Inner = ceres::Jet<double, X + Y>;
  using Outer = ceres::Jet<Inner, Y>;  // by y alone: its derivatives are Phi
  std::array<Outer, size_t(X + Y)> variables;
  for (int i = 0; i < X + Y; ++i) {
    Outer& variable = variables[size_t(i)];
    variable.a = Inner(i < X ? x[i] : y[i - X], i);
    for (int j = 0; j < Y; ++j) variable.v[j] = Inner(j == i - X ? 1.0 : 0.0);
  }
  const Outer value = cost(variables);
  Eigen::MatrixXd by_y(Y, Y), by_x(Y, X);
  for (int j = 0; j < Y; ++j) {
    for (int i = 0; i < X; ++i) by_x(j, i) = value.v[j].v[i];
    for (int i = 0; i < Y; ++i) by_y(j, i) = value.v[j].v[X + i];
  }
  return -by_y.fullPivLu().solve(by_x);
}

}  // namespace gaitcam
