/// Real roots of a polynomial: isolated by Sturm's theorem, then refined by false position.

#pragma once

#include <vector>

namespace gaitcam {

/// @param coefficients of x^0, x^1, ..., x^n; n at most 16. Leading zeros are dropped.
/// @returns the distinct real roots, in increasing order. A root of even multiplicity may be lost to rounding.
std::vector<double> RealRoots(const std::vector<double>& coefficients);

}  // namespace gaitcam
