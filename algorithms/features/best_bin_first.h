/// Approximate nearest neighbours of descriptors: the k-d tree searched best bin first (Beis and Lowe, CVPR 1997;
/// thesis 3.5.3).

#pragma once

#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace gaitcam {

/// The nearest and second nearest row of a query. Squared Euclidean distances for CV_32F, Hamming distances for CV_8U.
struct TwoNearest {
  int index = -1;
  float distance = std::numeric_limits<float>::infinity();
  int second_index = -1;
  float second_distance = std::numeric_limits<float>::infinity();

  /// Takes a candidate; of equal ones the lower index.
  void Offer(int i, float d) {
    if (d < distance || (d == distance && i < index)) {
      second_index = index;
      second_distance = distance;
      index = i;
      distance = d;
    } else if (d < second_distance || (d == second_distance && i < second_index)) {
      second_index = i;
      second_distance = d;
    }
  }
};

class BestBinFirstTree {
 public:
  /// Splits at the median of the dimension of largest variance; binary descriptors, at the bit whose mean is nearest to
  /// one half.
  /// @param descriptors CV_32FC1 or CV_8UC1, one per row; must outlive the tree.
  explicit BestBinFirstTree(const cv::Mat& descriptors);

  /// Takes more descriptors in: each goes to the leaf where a query for it begins, and a leaf that is full is split.
  /// The splits above were chosen before: a tree that grew compares more candidates for the same answer than one that
  /// was built at once.
  /// @param descriptors all of them, the known ones first; must outlive the tree in their place.
  void Grow(const cv::Mat& descriptors);

  /// Visits leaves in the order of their distance from the query, until `max_candidates` descriptors have been compared
  /// (0: as many as it takes to be exact).
  /// @param within bins farther than this are not entered, in units of TwoNearest::distance; what is farther may be
  /// missed.
  TwoNearest Search(const cv::Mat& query_row, int max_candidates,
                    float within = std::numeric_limits<float>::infinity()) const;

  /// Memory that the tree takes beside the descriptors.
  size_t bytes() const;

 private:
  struct Node {
    int dimension = -1;         ///< -1: a leaf.
    float split = 0;            ///< Descriptors with a smaller value lie to the left.
    int left = -1, right = -1;  ///< Nodes; a leaf has its number instead of the left one.
  };
  struct Branch;

  /// Makes node `index` and those below it of the rows `begin` to `end` of `order_`.
  void Build(int index, int begin, int end);
  void MakeLeaf(int index, int begin, int end);
  void Insert(int row);
  std::pair<int, float> ChooseSplit(int begin, int end) const;
  float Component(int row, int dimension) const;
  float Distance(const cv::Mat& query, int row) const;

  cv::Mat descriptors_;
  bool binary_;
  std::vector<int> order_;  ///< Rows that are being built.
  std::vector<Node> nodes_;
  std::vector<std::vector<int>> leaves_;  ///< Rows of each.
  int free_leaf_ = -1;                    ///< A number that the next leaf takes; -1: a new one.
};

/// Number of bits that differ.
int HammingDistance(const uchar* a, const uchar* b, int bytes);

}  // namespace gaitcam
