#include "algorithms/features/best_bin_first.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <queue>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/popcnt_clones.h"

namespace gaitcam {
namespace {

constexpr int kLeafSize = 4;
constexpr size_t kFullLeaf = 8;  // of a tree that grows: split again

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
  if (descriptors.rows == 0) return;
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.emplace_back();
  Build(0, 0, descriptors.rows);
  order_ = {};
}

void BestBinFirstTree::Grow(const cv::Mat& descriptors) {
  const int known = descriptors_.rows;
  GAITCAM_ASSERT(descriptors.rows >= known && descriptors.type() == (binary_ ? CV_8UC1 : CV_32FC1));
  descriptors_ = descriptors;
  if (nodes_.empty() && descriptors.rows > 0) {
    nodes_.emplace_back();
    MakeLeaf(0, 0, 0);
  }
  for (int row = known; row < descriptors.rows; ++row) Insert(row);
}

void BestBinFirstTree::Insert(int row) {
  int node = 0;
  while (nodes_[size_t(node)].dimension >= 0) {
    const Node& here = nodes_[size_t(node)];
    node = Component(row, here.dimension) < here.split ? here.left : here.right;
  }
  const size_t leaf = size_t(nodes_[size_t(node)].left);
  leaves_[leaf].push_back(row);
  if (leaves_[leaf].size() % kFullLeaf != 0) return;
  order_ = leaves_[leaf];
  leaves_[leaf].clear();  // the first leaf below takes its number
  free_leaf_ = int(leaf);
  Build(node, 0, int(order_.size()));
}

size_t BestBinFirstTree::bytes() const {
  size_t sum = nodes_.capacity() * sizeof(Node) + leaves_.capacity() * sizeof(std::vector<int>);
  for (const std::vector<int>& leaf : leaves_) sum += leaf.capacity() * sizeof(int);
  return sum;
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

void BestBinFirstTree::MakeLeaf(int index, int begin, int end) {
  if (free_leaf_ < 0) {
    free_leaf_ = int(leaves_.size());
    leaves_.emplace_back();
  }
  leaves_[size_t(free_leaf_)].assign(order_.begin() + begin, order_.begin() + end);
  nodes_[size_t(index)] = {-1, 0, std::exchange(free_leaf_, -1), -1};
}

void BestBinFirstTree::Build(int index, int begin, int end) {
  if (end - begin <= kLeafSize) return MakeLeaf(index, begin, end);
  const auto [dimension, split] = ChooseSplit(begin, end);
  if (dimension < 0) return MakeLeaf(index, begin, end);
  const auto middle = std::stable_partition(order_.begin() + begin, order_.begin() + end,
                                            [&, d = dimension, s = split](int row) { return Component(row, d) < s; });
  const int cut = int(middle - order_.begin());
  if (cut == begin || cut == end) return MakeLeaf(index, begin, end);
  const int left = int(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[size_t(index)] = {dimension, split, left, left + 1};
  Build(left, begin, cut);
  Build(left + 1, cut, end);
}

TwoNearest BestBinFirstTree::Search(const cv::Mat& query, int max_candidates, float within) const {
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
    if (branches[size_t(taken)].distance > std::min(nearest.second_distance, within)) break;  // nothing nearer is left
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
    for (const int row : leaves_[size_t(nodes_[size_t(node)].left)]) nearest.Offer(row, Distance(query, row));
    compared += int(leaves_[size_t(nodes_[size_t(node)].left)].size());
  }
  return nearest;
}

}  // namespace gaitcam
