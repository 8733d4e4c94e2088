/// Seeded random streams. A stream depends on the run's seed and its component's name alone, so that a new component
/// never shifts the numbers of another. Bit-identical on every platform (no std::*_distribution).

#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace gaitcam {

class RandomStream {
 public:
  RandomStream(uint64_t seed, std::string_view component);

  uint64_t Bits() { return engine_(); }
  /// Uniform in [0, 1).
  double Uniform();
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Uniform in {0, ..., n - 1}; n >= 1.
  int Index(int n);
  /// Zero mean, unit variance (Marsaglia's polar method).
  double Normal();
  double Normal(double mean, double sigma) { return mean + sigma * Normal(); }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace gaitcam
