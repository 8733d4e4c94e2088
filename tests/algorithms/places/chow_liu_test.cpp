#include "algorithms/places/chow_liu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "made_up_words.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
constexpr double kSmoothing = 0.5;

/// Images of `words` words of which some bring others along.
std::vector<WordSet> Images(int words, uint64_t seed) {
  RandomStream random(seed, "images");
  std::vector<WordSet> images;
  for (int image = 0; image < 100; ++image) {
    WordSet shown;
    for (int word = 0; word < words; ++word) {
      const bool with = !shown.empty() && random.Uniform() < 0.3;
      if (random.Uniform() < (with ? 0.8 : 0.3)) shown.push_back(word);
    }
    images.push_back(shown);
  }
  return images;
}

/// Parents of the tree that a Prüfer sequence stands for, seen from the last word.
std::vector<int> TreeOf(const std::vector<int>& code) {
  const int words = int(code.size()) + 2;
  std::vector<int> degree(size_t(words), 1), parent(size_t(words), -1);
  for (const int word : code) ++degree[size_t(word)];
  for (const int word : code) {
    for (int leaf = 0; leaf < words; ++leaf) {
      if (degree[size_t(leaf)] != 1) continue;
      parent[size_t(leaf)] = word;
      degree[size_t(leaf)] = 0;
      --degree[size_t(word)];
      break;
    }
  }
  for (int leaf = 0; leaf < words - 1; ++leaf) {
    if (degree[size_t(leaf)] == 1) parent[size_t(leaf)] = words - 1;
  }
  return parent;
}

double Weight(const std::vector<int>& parents, const std::vector<WordSet>& images) {
  double sum = 0;
  for (size_t word = 0; word < parents.size(); ++word) {
    if (parents[word] >= 0)
      sum += internal::MutualInformation(images, int(parents.size()), int(word), parents[word], kSmoothing);
  }
  return sum;
}

std::vector<int> ParentsOf(const ChowLiuTree& tree) {
  std::vector<int> parents;
  for (const ChowLiuTree::Node& node : tree.nodes) parents.push_back(node.parent);
  return parents;
}

TEST(ChowLiu, OfAllTreesItIsTheHeaviest) {
  constexpr int kWords = 5;  // 5^3 trees
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const std::vector<WordSet> images = Images(kWords, seed);
    double heaviest = 0;
    int trees = 0;
    for (int a = 0; a < kWords; ++a) {
      for (int b = 0; b < kWords; ++b) {
        for (int c = 0; c < kWords; ++c, ++trees) heaviest = std::max(heaviest, Weight(TreeOf({a, b, c}), images));
      }
    }
    EXPECT_EQ(trees, 125);
    // The same terms in another order.
    EXPECT_NEAR(Weight(ParentsOf(LearnChowLiuTree(images, kWords, kSmoothing)), images), heaviest, 1e-12);
  }
}

TEST(ChowLiu, MutualInformationIsThatOfTheCounts) {
  // 8 images: a alone in 2, b alone in 1, both in 3, neither in 2; and half an image to each: of 10 images.
  const std::vector<WordSet> images = {{0}, {0}, {1}, {0, 1}, {0, 1}, {0, 1}, {}, {}};
  const double pa = 0.6, pb = 0.5;
  const double expected = 0.25 * std::log(0.25 / (pa * (1 - pb))) + 0.15 * std::log(0.15 / ((1 - pa) * pb)) +
                          0.35 * std::log(0.35 / (pa * pb)) + 0.25 * std::log(0.25 / ((1 - pa) * (1 - pb)));
  EXPECT_NEAR(internal::MutualInformation(images, 2, 0, 1, kSmoothing), expected, 1e-12);
}

TEST(ChowLiu, ProbabilitiesOfAllImagesAddUpToOne) {
  const ChowLiuTree tree = LearnChowLiuTree(Images(6, 4), 6);
  double sum = 0;
  for (int bits = 0; bits < 64; ++bits) {
    WordSet words;
    for (int word = 0; word < 6; ++word) {
      if (bits >> word & 1) words.push_back(word);
    }
    sum += std::exp(LogProbability(tree, words));
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(ChowLiu, ConditionalsAreConsistentWithMarginals) {
  const ChowLiuTree tree = LearnChowLiuTree(Images(40, 4), 40);
  for (const ChowLiuTree::Node& node : tree.nodes) {
    if (node.parent < 0) continue;
    const double with = tree.nodes[size_t(node.parent)].p;
    EXPECT_NEAR(node.p_with_parent * with + node.p_without_parent * (1 - with), node.p, 1e-12);
  }
}

TEST(ChowLiu, WordsThatAlwaysComeTogetherAreLinked) {
  RandomStream random(8, "pairs");
  std::vector<WordSet> images;
  for (int image = 0; image < 200; ++image) {
    WordSet shown;
    for (int pair = 0; pair < 5; ++pair) {
      if (random.Uniform() < 0.5) shown.insert(shown.end(), {2 * pair, 2 * pair + 1});
    }
    images.push_back(shown);
  }
  const ChowLiuTree tree = LearnChowLiuTree(images, 10);
  for (int pair = 0; pair < 5; ++pair) {
    const bool linked =
        tree.nodes[size_t(2 * pair)].parent == 2 * pair + 1 || tree.nodes[size_t(2 * pair + 1)].parent == 2 * pair;
    EXPECT_TRUE(linked) << pair;
  }
}

TEST(ChowLiu, OneWordIsARoot) {
  const ChowLiuTree tree = LearnChowLiuTree({{0}, {}}, 1);
  EXPECT_EQ(tree.nodes[0].parent, -1);
  EXPECT_DOUBLE_EQ(tree.nodes[0].p, 0.5);
}

TEST(ChowLiu, SaysWhatIsWrongInOneLine) {
  EXPECT_THAT(ErrorOf([] { LearnChowLiuTree({{0}}, 0); }), HasSubstr("vocabulary is empty"));
  EXPECT_THAT(ErrorOf([] { LearnChowLiuTree({}, 3); }), HasSubstr("no training images"));
  EXPECT_THAT(ErrorOf([] { LearnChowLiuTree({{0}, {3}}, 3); }), HasSubstr("image 1 shows word 3 of a vocabulary of 3"));
}

}  // namespace
}  // namespace gaitcam
