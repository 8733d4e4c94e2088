#include "algorithms/core/random.h"

#include <cmath>

namespace gaitcam {
namespace {

/// 64-bit finaliser (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
uint64_t Mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

uint64_t StreamSeed(uint64_t seed, std::string_view component) {
  uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a over the name
  for (const unsigned char c : component) hash = (hash ^ c) * 0x100000001b3ULL;
  return Mix(Mix(seed + 0x9e3779b97f4a7c15ULL) ^ hash);
}

}  // namespace

RandomStream::RandomStream(uint64_t seed, std::string_view component) : engine_(StreamSeed(seed, component)) {}

double RandomStream::Uniform() { return double(engine_() >> 11) * 0x1.0p-53; }

int RandomStream::Index(int n) { return int(Uniform() * n); }

double RandomStream::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double u, v, s;
  do {
    u = Uniform(-1, 1);
    v = Uniform(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double scale = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * scale;
  has_spare_ = true;
  return u * scale;
}

}  // namespace gaitcam
