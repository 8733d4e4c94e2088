#include "algorithms/features/descriptor_distance.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <opencv2/core/hal/intrin.hpp>

#include "algorithms/core/avx_clones.h"
#include "algorithms/core/errors.h"
#include "algorithms/features/best_bin_first.h"

namespace gaitcam {
namespace {

constexpr size_t kRows = 4;  ///< At once: their sums need not wait for each other.
constexpr int kLanes = 8;
using DescriptorLanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using RowPointers = std::array<const float*, kRows>;

[[gnu::always_inline]] inline DescriptorLanes LoadLanes(const float* values) {
  DescriptorLanes lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}

/// Sums of squared differences between `query` and four rows over n values, a multiple of eight: eight for each row.
GAITCAM_AVX_CLONES void SumSquares(const float* query, const RowPointers& rows, int n, float (&sums)[kRows][kLanes]) {
  const float *const r0 = rows[0], *const r1 = rows[1], *const r2 = rows[2], *const r3 = rows[3];
  DescriptorLanes s0 = {}, s1 = {}, s2 = {}, s3 = {};
  for (int k = 0; k < n; k += kLanes) {
    const DescriptorLanes a = LoadLanes(query + k);
    const DescriptorLanes d0 = a - LoadLanes(r0 + k), d1 = a - LoadLanes(r1 + k);
    s0 += d0 * d0;
    s1 += d1 * d1;
    const DescriptorLanes d2 = a - LoadLanes(r2 + k), d3 = a - LoadLanes(r3 + k);
    s2 += d2 * d2;
    s3 += d3 * d3;
  }
  std::memcpy(sums[0], &s0, sizeof(s0));
  std::memcpy(sums[1], &s1, sizeof(s1));
  std::memcpy(sums[2], &s2, sizeof(s2));
  std::memcpy(sums[3], &s3, sizeof(s3));
}

/// Euclidean distances of `query` from four rows of n values. The order in which squares are added up is always the
/// same, whatever the processor.
void FourDistances(const float* query, const RowPointers& rows, int n, float* distances) {
  using Four = cv::v_float32x4;
  int k = n / kLanes * kLanes;
  alignas(16) float sums[kRows][kLanes];
  SumSquares(query, rows, k, sums);
  const auto halves = [&](size_t r) { return cv::v_load_aligned(sums[r]) + cv::v_load_aligned(sums[r] + 4); };
  Four s0 = halves(0), s1 = halves(1), s2 = halves(2), s3 = halves(3);
  if (k + 4 <= n) {
    const auto squares = [&](size_t r) {
      const Four d = cv::v_load(query + k) - cv::v_load(rows[r] + k);
      return d * d;
    };
    s0 += squares(0);
    s1 += squares(1);
    s2 += squares(2);
    s3 += squares(3);
    k += 4;
  }
  Four a, b, c, d;
  cv::v_transpose4x4(s0, s1, s2, s3, a, b, c, d);
  Four sum = (a + c) + (b + d);
  for (; k < n; ++k) {
    const Four off = cv::v_setall_f32(query[k]) - Four(rows[0][k], rows[1][k], rows[2][k], rows[3][k]);
    sum += off * off;
  }
  cv::v_store(distances, cv::v_sqrt(sum));
}

}  // namespace

void DescriptorDistances(const cv::Mat& query, const cv::Mat& rows, const std::vector<int>& chosen,
                         std::vector<float>& distances) {
  GAITCAM_ASSERT(query.type() == rows.type() && query.cols == rows.cols);
  distances.resize(chosen.size());
  if (rows.type() == CV_8UC1) {
    for (size_t i = 0; i < chosen.size(); ++i) {
      distances[i] = float(HammingDistance(query.ptr(), rows.ptr(chosen[i]), rows.cols));
    }
    return;
  }
  GAITCAM_ASSERT(rows.type() == CV_32FC1);
  const float *const q = query.ptr<float>(), *const first = rows.ptr<float>();
  const size_t stride = rows.step1(), whole = chosen.size() / kRows * kRows;
  const auto row = [&](size_t i) { return first + stride * size_t(chosen[i]); };
  for (size_t i = 0; i < whole; i += kRows) {
    FourDistances(q, {row(i), row(i + 1), row(i + 2), row(i + 3)}, rows.cols, &distances[i]);
  }
  if (whole == chosen.size()) return;
  const size_t last = chosen.size() - 1;
  float rest[kRows];
  FourDistances(q, {row(whole), row(std::min(whole + 1, last)), row(std::min(whole + 2, last)), row(last)}, rows.cols,
                rest);
  std::copy_n(rest, chosen.size() - whole, distances.begin() + long(whole));
}

}  // namespace gaitcam
