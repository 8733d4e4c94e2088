/// Loop closure detection: a discrete Bayes filter over the nodes of the map and the event "none of them" (thesis 4.5,
/// Eqs. 4.5-4.6).
///
/// State 0 is "no loop", the thesis's -1; state i + 1 is node i. The node visited last is excluded, and any that the
/// robot cannot have reached. One number, the threshold, is both the similarity at which a view still shows the last
/// node and the likelihood of "no loop".
///
/// Likelihood, by `likelihood`:
/// - "similarity": the thesis's. L(i) = Sim of node i, L(no loop) = threshold.
/// - "bits": of n independent bits, Binomial(n, p1) disagree where the view shows the node, Binomial(n, p0) where the
///   best window of another place is compared; d is the share that does. The ratio's logarithm is linear in d,
///     log L(i) / L(no loop) = n log(p0 (1 - p1) / (p1 (1 - p0))) (d_th - d) = sharpness (d_th - d),
///   and 0 at d_th = 1 / (2 threshold), the inverse of SimilarityOf. Bits are far from independent, as the image was
///   smoothed over a square: `sharpness` stands for n times the logarithm.
///
/// Transitions, by `transition`: "uniform", the thesis's; or "neighbours": with probability `teleport` the next state
/// is any, else it is the same or one that is linked with it, all equally probable.

#pragma once

#include <array>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/place_graph.h"

namespace gaitcam {

enum class LoopLikelihood { kBits, kSimilarity };
constexpr auto WordsOf(LoopLikelihood) {
  return std::array{EnumWord{LoopLikelihood::kBits, "bits"}, EnumWord{LoopLikelihood::kSimilarity, "similarity"}};
}

enum class LoopTransition { kUniform, kNeighbours };
constexpr auto WordsOf(LoopTransition) {
  return std::array{EnumWord{LoopTransition::kUniform, "uniform"}, EnumWord{LoopTransition::kNeighbours, "neighbours"}};
}

struct LoopFilterOptions {
  using DescribedTag = void;
  double threshold = 2.1;  ///< Of similarity; that of unrelated images is 1 (SimilarityOf).
  LoopLikelihood likelihood = LoopLikelihood::kBits;
  double sharpness = 60;
  LoopTransition transition = LoopTransition::kNeighbours;
  double teleport = 0.3;
};

template <class Visitor>
void VisitFields(Visitor& visit, LoopFilterOptions& o) {
  visit("threshold", o.threshold, Between(1.0, 1000.0), "similarity from which on a view shows a place");
  visit("likelihood", o.likelihood, EnumWords<LoopLikelihood>(), "of a node, given its similarity");
  visit("sharpness", o.sharpness, Between(0.1, 10000.0), "of the likelihood `bits`");
  visit("transition", o.transition, EnumWords<LoopTransition>(), "between two tests");
  visit("teleport", o.teleport, Between(1e-6, 1.0), "probability of a transition to any state");
}

class LoopFilter {
 public:
  explicit LoopFilter(const LoopFilterOptions& options = {});

  struct Belief {
    std::vector<double> likelihood;  ///< Of "no loop", then of each node; 0 for those excluded.
    std::vector<double> posterior;   ///< Likewise; sum 1.
    int best = -1;                   ///< Eq. 4.5: the most probable node, or -1.
  };

  /// One step of Eq. 4.6. @param similarity of each node; there may be more nodes than before. @param left_out of each
  /// node, whether it is excluded. @param links between nodes. @pre as many of both; no fewer than before.
  Belief Update(const std::vector<double>& similarity, const std::vector<bool>& left_out,
                const std::vector<PlaceLink>& links);
  /// Before the next step nothing is known.
  void Reset() { belief_.clear(); }

 private:
  std::vector<double> Predict(size_t states, const std::vector<PlaceLink>& links) const;
  double Likelihood(double similarity) const;

  LoopFilterOptions options_;
  std::vector<double> belief_;
};

}  // namespace gaitcam
