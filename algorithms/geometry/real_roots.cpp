#include "algorithms/geometry/real_roots.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kMaxDegree = 16;

struct Polynomial {
  std::array<double, kMaxDegree + 1> c{};  ///< Of x^0, x^1, ...
  int degree = -1;                         ///< -1: zero.

  double operator()(double x) const {
    double value = 0;
    for (int i = degree; i >= 0; --i) value = value * x + c[size_t(i)];
    return value;
  }
  double MaxCoefficient() const {
    double largest = 0;
    for (int i = 0; i <= degree; ++i) largest = std::max(largest, std::abs(c[size_t(i)]));
    return largest;
  }
  /// Drops leading coefficients that are at most `zero`, and scales the largest to 1.
  void Normalise(double zero) {
    while (degree >= 0 && !(std::abs(c[size_t(degree)]) > zero)) --degree;
    const double largest = MaxCoefficient();
    for (int i = 0; i <= degree; ++i) c[size_t(i)] /= largest;
  }
};

Polynomial Derivative(const Polynomial& p) {
  Polynomial d;
  d.degree = p.degree - 1;
  for (int i = 1; i <= p.degree; ++i) d.c[size_t(i - 1)] = i * p.c[size_t(i)];
  return d;
}

/// -(a modulo b), up to a positive factor.
Polynomial NegatedRemainder(Polynomial a, const Polynomial& b) {
  const double before = a.MaxCoefficient();
  for (int i = a.degree; i >= b.degree; --i) {
    const double factor = a.c[size_t(i)] / b.c[size_t(b.degree)];
    for (int k = 0; k <= b.degree; ++k) a.c[size_t(i - b.degree + k)] -= factor * b.c[size_t(k)];
  }
  a.degree = b.degree - 1;
  for (double& c : a.c) c = -c;
  constexpr double kRounding = 1e-14;
  a.Normalise(kRounding * before);
  return a;
}

/// Sturm's chain: p, p', and negated remainders of each pair.
class SturmChain {
 public:
  explicit SturmChain(const Polynomial& p) : length_(1) {
    chain_[0] = p;
    Polynomial next = Derivative(p);
    next.Normalise(0);
    while (next.degree >= 0) {
      chain_[size_t(length_++)] = next;
      if (next.degree == 0) break;
      next = NegatedRemainder(chain_[size_t(length_ - 2)], chain_[size_t(length_ - 1)]);
    }
  }

  /// Sign changes along the chain: V(a) - V(b) is the number of distinct roots in (a, b].
  int Changes(double x) const {
    int changes = 0;
    bool negative = false, any = false;
    for (int i = 0; i < length_; ++i) {
      const double value = chain_[size_t(i)](x);
      if (value == 0) continue;
      changes += any && (value < 0) != negative;
      negative = value < 0;
      any = true;
    }
    return changes;
  }
  double Value(double x) const { return chain_[0](x); }

 private:
  std::array<Polynomial, kMaxDegree + 1> chain_;
  int length_;
};

/// The one root in (a, b], by false position (Illinois) where the sign changes, else by counting.
double Narrow(const SturmChain& chain, double a, double b, int changes_a) {
  constexpr double kWidth = 1e-15, kWidthByCounting = 1e-9;
  double fa = chain.Value(a), fb = chain.Value(b);
  if (fb == 0) return b;
  if ((fa < 0) == (fb < 0) || fa == 0) {  // of even multiplicity, or a is the neighbour's root
    while (b - a > kWidthByCounting) {
      const double middle = (a + b) / 2;
      (chain.Changes(middle) == changes_a ? a : b) = middle;
    }
    return (a + b) / 2;
  }
  constexpr int kMaxSteps = 100;
  int side = 0;
  for (int step = 0; step < kMaxSteps && b - a > kWidth; ++step) {
    double x = (a * fb - b * fa) / (fb - fa);
    if (!(x > a && x < b) || step % 4 == 3) x = (a + b) / 2;  // every fourth step bisects
    const double f = chain.Value(x);
    if (f == 0) return x;
    if ((f < 0) == (fb < 0)) {
      b = x;
      fb = f;
      if (side == -1) fa /= 2;
      side = -1;
    } else {
      a = x;
      fa = f;
      if (side == 1) fb /= 2;
      side = 1;
    }
  }
  return (a + b) / 2;
}

void Isolate(const SturmChain& chain, double a, double b, int changes_a, int changes_b, std::vector<double>& roots) {
  const int count = changes_a - changes_b;
  if (count <= 0) return;
  if (count == 1) {
    roots.push_back(Narrow(chain, a, b, changes_a));
    return;
  }
  const double middle = (a + b) / 2;
  constexpr double kInseparable = 1e-12;
  if (b - a < kInseparable) {
    roots.push_back(middle);
    return;
  }
  const int changes = chain.Changes(middle);
  Isolate(chain, a, middle, changes_a, changes, roots);
  Isolate(chain, middle, b, changes, changes_b, roots);
}

std::vector<double> RootsWithinOne(const Polynomial& p) {
  std::vector<double> roots;
  const SturmChain chain(p);
  Isolate(chain, -1, 1, chain.Changes(-1), chain.Changes(1), roots);
  return roots;
}

}  // namespace

std::vector<double> RealRoots(const std::vector<double>& coefficients) {
  GAITCAM_ASSERT(coefficients.size() <= kMaxDegree + 1);
  Polynomial p;
  p.degree = int(coefficients.size()) - 1;
  std::copy(coefficients.begin(), coefficients.end(), p.c.begin());
  if (!std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return std::isfinite(c); })) return {};
  p.Normalise(0);
  if (p.degree < 1) return {};
  std::vector<double> roots = RootsWithinOne(p);
  // Roots beyond one are one over the roots of the polynomial with its coefficients reversed.
  Polynomial reversed = p;
  std::reverse(reversed.c.begin(), reversed.c.begin() + p.degree + 1);
  reversed.Normalise(0);
  if (reversed.degree >= 1) {
    for (const double root : RootsWithinOne(reversed)) {
      if (root != 0 && std::abs(root) < 1) roots.push_back(1 / root);
    }
  }
  std::sort(roots.begin(), roots.end());
  return roots;
}

}  // namespace gaitcam
