#include "algorithms/features/descriptor_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "algorithms/core/avx_clones.h"
#include "algorithms/core/errors.h"
#include "algorithms/features/best_bin_first.h"

namespace gaitcam {
namespace {

constexpr size_t kAtOnce = 4;  ///< Rows whose sums need not wait for each other.
constexpr int kLanes = 8;
using DescriptorLanes = float __attribute__((vector_size(kLanes * sizeof(float))));

/// Euclidean distances of `query` from four rows of n values. Eight sums of squares for each row, added up in pairs;
/// what is left of the row comes last.
GAITCAM_AVX_CLONES void FourDistances(const float* query, const std::array<const float*, kAtOnce>& rows, int n,
                                      std::array<float, kAtOnce>& distances) {
  DescriptorLanes sums[kAtOnce] = {};
  int k = 0;
  for (; k + kLanes <= n; k += kLanes) {
    DescriptorLanes a, b;
    std::memcpy(&a, query + k, sizeof(a));
    for (size_t r = 0; r < kAtOnce; ++r) {
      std::memcpy(&b, rows[r] + k, sizeof(b));
      const DescriptorLanes d = a - b;
      sums[r] += d * d;
    }
  }
  const auto square = [&](size_t r, int i) {
    const float d = query[i] - rows[r][i];
    return d * d;
  };
  for (size_t r = 0; r < kAtOnce; ++r) {
    float four[4];
    for (int i = 0; i < 4; ++i) four[i] = sums[r][i] + sums[r][i + 4];
    int rest = k;
    if (rest + 4 <= n) {
      for (int i = 0; i < 4; ++i) four[i] += square(r, rest + i);
      rest += 4;
    }
    float sum = (four[0] + four[2]) + (four[1] + four[3]);
    for (; rest < n; ++rest) sum += square(r, rest);
    distances[r] = std::sqrt(sum);
  }
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
  std::array<float, kAtOnce> four{};
  std::array<const float*, kAtOnce> pointers{};
  for (size_t i = 0; i < chosen.size(); i += kAtOnce) {
    const size_t count = std::min(kAtOnce, chosen.size() - i);
    for (size_t r = 0; r < kAtOnce; ++r) pointers[r] = rows.ptr<float>(chosen[i + std::min(r, count - 1)]);
    FourDistances(query.ptr<float>(), pointers, rows.cols, four);
    std::copy_n(four.begin(), count, distances.begin() + long(i));
  }
}

}  // namespace gaitcam
