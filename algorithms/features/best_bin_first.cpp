#include "algorithms/features/best_bin_first.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <queue>

#include "algorithms/core/errors.h"
#include "algorithms/core/popcnt_clones.h"

namespace gaitcam {
namespace {

constexpr int kLeafSize = 4;

float SquaredDistance(const float* a, const float* b, int n) {
  std::array<float, 4> sums{};  // four sums that need not wait for each other
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    for (size_t s = 0; s < 4; ++s) {
      const float d = a[size_t(k) + s] - b[size_t(k) + s];
      sums[s] += d * d;
    }
  }
  for (; k < n; ++k) sums[0] += (a[k] - b[k]) * (a[k] - b[k]);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

float ComponentOf(const cv::Mat& descriptors, int row, int dimension, bool binary) {
  if (!binary) return descriptors.ptr<float>(row)[dimension];
  return float((descriptors.ptr<uchar>(row)[dimension / 8] >> (dimension % 8)) & 1);
}

}  // namespace

GAITCAM_POPCNT_CLONES int HammingDistance(const uchar* a, const uchar* b, int bytes) {
  int bits = 0, k = 0;
  for (; k + 8 <= bytes; k += 8) {
    uint64_t x, y;
    std::memcpy(&x, a + k, 8);
    std::memcpy(&y, b + k, 8);
    bits += std::popcount(x ^ y);
  }
  for (; k < bytes; ++k) bits += std::popcount(uchar(a[k] ^ b[k]));
  return bits;
}

/// A node not yet entered, and how far the query is from its bin: the sum over dimensions of the squared offset to the
/// bin's nearest face. `parent` leads along the offsets that were taken.
struct BestBinFirstTree::Branch {
  float distance = 0;
  int node = 0;
  int dimension = -1;
  float offset2 = 0;
  int parent = -1;
};

BestBinFirstTree::BestBinFirstTree(const cv::Mat& descriptors)
    : descriptors_(descriptors), binary_(descriptors.type() == CV_8UC1), order_(size_t(descriptors.rows)) {
  GAITCAM_ASSERT(binary_ || descriptors.type() == CV_32FC1);
  std::iota(order_.begin(), order_.end(), 0);
  if (descriptors.rows > 0) Build(0, descriptors.rows);
}

float BestBinFirstTree::Component(int row, int dimension) const {
  return ComponentOf(descriptors_, row, dimension, binary_);
}

float BestBinFirstTree::Distance(const cv::Mat& query, int row) const {
  if (binary_) return float(HammingDistance(query.ptr(), descriptors_.ptr(row), descriptors_.cols));
  return SquaredDistance(query.ptr<float>(), descriptors_.ptr<float>(row), descriptors_.cols);
}

/// @returns dimension and median; dimension -1 if all are equal.
std::pair<int, float> BestBinFirstTree::ChooseSplit(int begin, int end) const {
  const int dimensions = descriptors_.cols * (binary_ ? 8 : 1);
  constexpr int kMaxSamples = 100;  // enough to rank variances
  const int stride = std::max(1, (end - begin) / kMaxSamples);
  std::vector<double> sum(size_t(dimensions), 0.0), sum2(sum);
  int count = 0;
  for (int i = begin; i < end; i += stride, ++count) {
    for (int d = 0; d < dimensions; ++d) {
      const double value = Component(order_[size_t(i)], d);
      sum[size_t(d)] += value;
      sum2[size_t(d)] += value * value;
    }
  }
  int widest = -1;
  double variance = 0;
  for (int d = 0; d < dimensions; ++d) {
    const double v = sum2[size_t(d)] / count - std::pow(sum[size_t(d)] / count, 2);
    if (v > variance * (1 + 1e-9) && v > 1e-12) {
      variance = v;
      widest = d;
    }
  }
  if (widest < 0 || binary_) return {widest, 0.5f};
  std::vector<float> values;
  for (int i = begin; i < end; ++i) values.push_back(Component(order_[size_t(i)], widest));
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  const float median = values[values.size() / 2];
  if (*std::min_element(values.begin(), values.end()) < median) return {widest, median};
  float above = std::numeric_limits<float>::infinity();  // half of them or more are the smallest: split above it
  for (const float value : values) {
    if (value > median) above = std::min(above, value);
  }
  return {std::isfinite(above) ? widest : -1, above};
}

int BestBinFirstTree::Build(int begin, int end) {
  const int index = int(nodes_.size());
  nodes_.push_back({-1, 0, begin, end});
  if (end - begin <= kLeafSize) return index;
  const auto [dimension, split] = ChooseSplit(begin, end);
  if (dimension < 0) return index;
  const auto middle = std::stable_partition(order_.begin() + begin, order_.begin() + end,
                                            [&, d = dimension, s = split](int row) { return Component(row, d) < s; });
  const int cut = int(middle - order_.begin());
  if (cut == begin || cut == end) return index;
  const int left = Build(begin, cut), right = Build(cut, end);
  nodes_[size_t(index)] = {dimension, split, left, right};
  return index;
}

TwoNearest BestBinFirstTree::Search(const cv::Mat& query, int max_candidates) const {
  TwoNearest nearest;
  if (nodes_.empty()) return nearest;
  std::vector<Branch> branches = {{}};
  const auto farther = [&](int a, int b) {
    const Branch &p = branches[size_t(a)], &q = branches[size_t(b)];
    return p.distance != q.distance ? p.distance > q.distance : a > b;
  };
  std::vector<int> heap = {0};
  int compared = 0;
  while (!heap.empty() && (max_candidates == 0 || compared < max_candidates)) {
    std::pop_heap(heap.begin(), heap.end(), farther);
    const int taken = heap.back();
    heap.pop_back();
    if (branches[size_t(taken)].distance > nearest.second_distance) break;  // no bin can hold anything nearer
    int node = branches[size_t(taken)].node;
    while (nodes_[size_t(node)].dimension >= 0) {
      const Node& here = nodes_[size_t(node)];
      const float offset = ComponentOf(query, 0, here.dimension, binary_) - here.split;
      // For a bit the split lies at 0.5: the other bin is one bit away.
      const float offset2 = binary_ ? 1.0f : offset * offset;
      float before = 0;  // offset along this dimension that is part of the distance already
      for (int b = taken; b >= 0; b = branches[size_t(b)].parent) {
        if (branches[size_t(b)].dimension == here.dimension) {
          before = branches[size_t(b)].offset2;
          break;
        }
      }
      const float distance = branches[size_t(taken)].distance + (offset2 - before);
      branches.push_back({distance, offset < 0 ? here.right : here.left, here.dimension, offset2, taken});
      heap.push_back(int(branches.size()) - 1);
      std::push_heap(heap.begin(), heap.end(), farther);
      node = offset < 0 ? here.left : here.right;
    }
    for (int i = nodes_[size_t(node)].left; i < nodes_[size_t(node)].right; ++i, ++compared) {
      nearest.Offer(order_[size_t(i)], Distance(query, order_[size_t(i)]));
    }
  }
  return nearest;
}

}  // namespace gaitcam
