/// Which words of a vocabulary appear together: the Chow-Liu tree (C. Chow and C. Liu, "Approximating discrete
/// probability distributions with dependence trees", IEEE Trans. Information Theory 14(3), 1968).
///
/// Of all distributions in which each binary variable depends on one other, the tree of the greatest sum of mutual
/// information is the nearest to the observed one. It is the spanning tree of that weight.

#pragma once

#include <vector>

#include "algorithms/places/visual_words.h"

namespace gaitcam {

/// p(z_q | z_parent) of each word q; z_q = 1: an image shows it.
struct ChowLiuTree {
  struct Node {
    int parent = -1;              ///< -1: the root.
    double p = 0;                 ///< p(z_q = 1), in (0, 1).
    double p_without_parent = 0;  ///< p(z_q = 1 | z_parent = 0); of the root p.
    double p_with_parent = 0;     ///< p(z_q = 1 | z_parent = 1); of the root p.
  };
  std::vector<Node> nodes;  ///< One per word.

  int size() const { return int(nodes.size()); }
};

/// @param images what each training image shows. @param smoothing images that are added to each of the four
/// combinations of two words, so that nothing is impossible because a few hundred images did not show it; > 0.
/// @throws BadInput without images or words, or if an image shows a word that there is none of.
ChowLiuTree LearnChowLiuTree(const std::vector<WordSet>& images, int words, double smoothing = 0.5);

/// Of an image's words by the tree, in nats.
double LogProbability(const ChowLiuTree& tree, const WordSet& words);

namespace internal {
/// In nats, of two words by the same smoothed counts. @pre a != b, both < words.
double MutualInformation(const std::vector<WordSet>& images, int words, int a, int b, double smoothing);
}  // namespace internal

}  // namespace gaitcam
