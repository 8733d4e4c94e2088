#include "results/scoring/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

constexpr size_t kMaxExactPairs = 50;

/// Twice the rank of each value, so that the mean ranks of ties are whole numbers.
std::vector<int> DoubledRanks(const std::vector<double>& sizes) {
  std::vector<size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return sizes[a] < sizes[b]; });
  std::vector<int> doubled(sizes.size());
  for (size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && sizes[order[end]] == sizes[order[first]]) ++end;
    for (size_t i = first; i < end; ++i) doubled[order[i]] = int(first + 1 + end);  // ranks first + 1 to end
  }
  return doubled;
}

/// Chances of every sum of the ranks whose difference is positive, if each sign were a fair coin: the product of the
/// polynomials (1 + x^rank) / 2.
std::vector<double> SumDistribution(const std::vector<int>& doubled_ranks) {
  std::vector<double> chance{1};
  for (const int rank : doubled_ranks) {
    std::vector<double> next(chance.size() + size_t(rank), 0);
    for (size_t sum = 0; sum < chance.size(); ++sum) {
      next[sum] += chance[sum] / 2;
      next[sum + size_t(rank)] += chance[sum] / 2;
    }
    chance = std::move(next);
  }
  return chance;
}

/// Chance that a standard normal variable exceeds z.
double UpperTail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

void ExactChances(const std::vector<int>& doubled_ranks, int doubled_sum, SignedRankTest& test) {
  const std::vector<double> chance = SumDistribution(doubled_ranks);
  const auto at = chance.begin() + doubled_sum;
  test.p_greater = std::min(1.0, std::accumulate(at, chance.end(), 0.0));
  test.p_less = std::min(1.0, std::accumulate(chance.begin(), at + 1, 0.0));
}

/// The sum's mean is half of all ranks, its variance a quarter of their squares (which holds with ties).
void NormalChances(const std::vector<int>& doubled_ranks, int doubled_sum, SignedRankTest& test) {
  double mean = 0, variance = 0;
  for (const int doubled : doubled_ranks) {
    mean += doubled / 4.0;
    variance += doubled * doubled / 16.0;
  }
  const double above = doubled_sum / 2.0 - mean, sigma = std::sqrt(variance);
  test.p_greater = UpperTail((above - 0.5) / sigma);
  test.p_less = UpperTail((-above - 0.5) / sigma);
}

}  // namespace

double MedianOf(std::vector<double> values) { return QuantileOf(std::move(values), 0.5); }

double QuantileOf(std::vector<double> values, double fraction) {
  GAITCAM_ASSERT(fraction >= 0 && fraction <= 1);
  if (values.empty()) return kNaN;
  std::sort(values.begin(), values.end());
  const double place = fraction * double(values.size() - 1);
  const size_t below = size_t(place);
  if (below + 1 == values.size()) return values.back();
  const double between = place - double(below);
  if (between == 0) return values[below];
  if (between == 0.5) return (values[below] + values[below + 1]) / 2;
  return values[below] + between * (values[below + 1] - values[below]);
}

SignedRankTest TestSignedRanks(const std::vector<double>& differences) {
  std::vector<double> sizes;
  std::vector<bool> positive;
  for (const double difference : differences) {
    GAITCAM_ASSERT(std::isfinite(difference));
    if (difference == 0) continue;
    sizes.push_back(std::abs(difference));
    positive.push_back(difference > 0);
  }
  SignedRankTest test;
  test.pairs = int(sizes.size());
  if (sizes.empty()) return test;
  const std::vector<int> doubled_ranks = DoubledRanks(sizes);
  int doubled_sum = 0;
  for (size_t i = 0; i < sizes.size(); ++i) doubled_sum += positive[i] ? doubled_ranks[i] : 0;
  if (sizes.size() <= kMaxExactPairs) {
    ExactChances(doubled_ranks, doubled_sum, test);
  } else {
    NormalChances(doubled_ranks, doubled_sum, test);
  }
  test.p_two_sided = std::min(1.0, 2 * std::min(test.p_greater, test.p_less));
  return test;
}

double HodgesLehmann(const std::vector<double>& differences) {
  std::vector<double> means;
  means.reserve(differences.size() * (differences.size() + 1) / 2);
  for (size_t i = 0; i < differences.size(); ++i) {
    for (size_t j = i; j < differences.size(); ++j) means.push_back((differences[i] + differences[j]) / 2);
  }
  return MedianOf(std::move(means));
}

ConfidenceInterval BootstrapMedian(const std::vector<double>& values, double confidence, int resamples,
                                   RandomStream& random) {
  GAITCAM_ASSERT(confidence > 0 && confidence < 1 && resamples > 0);
  if (values.empty()) return {kNaN, kNaN};
  std::vector<double> medians(static_cast<size_t>(resamples)), drawn(values.size());
  for (double& median : medians) {
    for (double& value : drawn) value = values[size_t(random.Index(int(values.size())))];
    median = MedianOf(drawn);
  }
  return {QuantileOf(medians, (1 - confidence) / 2), QuantileOf(medians, (1 + confidence) / 2)};
}

std::vector<double> HolmAdjusted(const std::vector<double>& p) {
  std::vector<size_t> order(p.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double largest = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, std::min(1.0, double(p.size() - i) * p[order[i]]));
    adjusted[order[i]] = largest;
  }
  return adjusted;
}

}  // namespace gaitcam
