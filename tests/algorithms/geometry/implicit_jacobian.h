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

/// dy/dx where y minimises C(x, y) (Valencia, Eq. 2.23), all second derivatives by jets of jets: C by each variable in
/// turn, by all of y at once.
/// @param cost  (const std::array<T, X + Y>&) -> T for jets of jets T, constants by Number<T>(); x first, then y
template <int X, int Y, class Cost>
Eigen::MatrixXd ImplicitJacobian(const Cost& cost, const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  using Inner = ceres::Jet<double, 1>;
  using Outer = ceres::Jet<Inner, Y>;  // by y alone: its derivatives are Phi
  Eigen::MatrixXd by_all(Y, X + Y);
  for (int turn = 0; turn < X + Y; ++turn) {
    std::array<Outer, size_t(X + Y)> variables;
    for (int i = 0; i < X + Y; ++i) {
      Outer& variable = variables[size_t(i)];
      variable.a = Inner(i < X ? x[i] : y[i - X]);
      variable.a.v[0] = i == turn ? 1.0 : 0.0;
      for (int j = 0; j < Y; ++j) variable.v[j] = Inner(j == i - X ? 1.0 : 0.0);
    }
    const Outer value = cost(variables);
    for (int j = 0; j < Y; ++j) by_all(j, turn) = value.v[j].v[0];
  }
  return -by_all.rightCols<Y>().fullPivLu().solve(by_all.leftCols<X>());
}

}  // namespace gaitcam
