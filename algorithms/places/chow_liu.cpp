#include "algorithms/places/chow_liu.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Which images show a word: 64 images to a number.
class Appearances {
 public:
  Appearances(const std::vector<WordSet>& images, int words, double smoothing)
      : images_(images.size()), smoothing_(smoothing), shown_(size_t(words)) {
    for (auto& row : shown_) row.assign((images.size() + 63) / 64, 0);
    for (size_t image = 0; image < images.size(); ++image) {
      for (const int word : images[image]) {
        if (word < 0 || word >= words) {
          throw BadInput("places: training image " + std::to_string(image) + " shows word " + std::to_string(word) +
                         " of a vocabulary of " + std::to_string(words));
        }
        shown_[size_t(word)][image / 64] |= uint64_t(1) << (image % 64);
      }
    }
  }

  double Probability(int word) const { return Smoothed(Count(word, word), 2); }
  /// That an image shows both.
  double Probability(int a, int b) const { return Smoothed(Count(a, b), 1); }

  /// Sum of p(a, b) log(p(a, b) / p(a) p(b)) over all four combinations.
  double MutualInformation(int a, int b) const {
    const double pa = Probability(a), pb = Probability(b), both = Probability(a, b);
    const auto term = [](double joint, double p, double q) { return joint * std::log(joint / (p * q)); };
    return term(both, pa, pb) + term(pa - both, pa, 1 - pb) + term(pb - both, 1 - pa, pb) +
           term(1 - pa - pb + both, 1 - pa, 1 - pb);
  }

 private:
  int Count(int a, int b) const {
    int count = 0;
    for (size_t k = 0; k < shown_[size_t(a)].size(); ++k)
      count += std::popcount(shown_[size_t(a)][k] & shown_[size_t(b)][k]);
    return count;
  }
  /// `parts`: of the four combinations, how many the event consists of.
  double Smoothed(int count, int parts) const {
    return (count + parts * smoothing_) / (double(images_) + 4 * smoothing_);
  }

  size_t images_;
  double smoothing_;
  std::vector<std::vector<uint64_t>> shown_;
};

/// Prim's algorithm from word 0: the parent of each word, of equals the first.
std::vector<int> GreatestSpanningTree(const Appearances& appearances, int words) {
  std::vector<int> parent(size_t(words), -1);
  std::vector<double> weight(size_t(words), -1);
  std::vector<bool> taken(size_t(words), false);
  for (int last = 0, count = 1; count < words; ++count) {
    taken[size_t(last)] = true;
    int best = -1;
    for (int word = 0; word < words; ++word) {
      if (taken[size_t(word)]) continue;
      const double information = appearances.MutualInformation(last, word);
      if (information > weight[size_t(word)]) {
        weight[size_t(word)] = information;
        parent[size_t(word)] = last;
      }
      if (best < 0 || weight[size_t(word)] > weight[size_t(best)]) best = word;
    }
    last = best;
  }
  return parent;
}

}  // namespace

ChowLiuTree LearnChowLiuTree(const std::vector<WordSet>& images, int words, double smoothing) {
  if (words < 1) throw BadInput("places: the vocabulary is empty, no tree of its words can be learned");
  if (images.empty()) throw BadInput("places: no training images to learn which words appear together");
  GAITCAM_ASSERT(smoothing > 0);
  const Appearances appearances(images, words, smoothing);
  const std::vector<int> parents = GreatestSpanningTree(appearances, words);
  ChowLiuTree tree;
  for (int word = 0; word < words; ++word) {
    const int parent = parents[size_t(word)];
    const double p = appearances.Probability(word);
    ChowLiuTree::Node node{parent, p, p, p};
    if (parent >= 0) {
      const double with = appearances.Probability(parent), both = appearances.Probability(word, parent);
      node.p_with_parent = both / with;
      node.p_without_parent = (p - both) / (1 - with);
    }
    tree.nodes.push_back(node);
  }
  return tree;
}

double LogProbability(const ChowLiuTree& tree, const WordSet& words) {
  std::vector<bool> shown(tree.nodes.size(), false);
  for (const int word : words) shown[size_t(word)] = true;
  double sum = 0;
  for (size_t word = 0; word < tree.nodes.size(); ++word) {
    const ChowLiuTree::Node& node = tree.nodes[word];
    const double p = node.parent >= 0 && shown[size_t(node.parent)] ? node.p_with_parent : node.p_without_parent;
    sum += std::log(shown[word] ? p : 1 - p);
  }
  return sum;
}

namespace internal {
double MutualInformation(const std::vector<WordSet>& images, int words, int a, int b, double smoothing) {
  return Appearances(images, words, smoothing).MutualInformation(a, b);
}
}  // namespace internal

}  // namespace gaitcam
