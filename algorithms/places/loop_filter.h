/// Has the robot come back to a place it knows? A discrete Bayes filter over the nodes of the map and the event "none
/// of them" (thesis 4.5, Eqs. 4.5-4.6).
///
/// State 0 is "no loop", the thesis's -1; state i + 1 is node i. The node visited last is left out, and any
/// that the robot cannot have come to. One number, the threshold, is both what a view must reach to show the last node
/// still, and the likelihood of "no loop".
///
/// Likelihood, by `likelihood`:
/// - "similarity": the thesis's. L(i) = Sim of node i, L(no loop) = threshold.
/// - "bits": of n independent bits, Binomial(n, p1) disagree where the view shows the node, Binomial(n, p0) where the
///   best window of another place is compared; d is the share that does. The ratio's logarithm is linear in d,
///     log L(i) / L(no loop) = n log(p0 (1 - p1) / (p1 (1 - p0))) (d_th - d) = sharpness (d_th - d),
///   and 0 at d_th = 1 / (2 threshold), SimilarityOf's inverse. Bits are far from independent, as the image was
///   smoothed over a square: `sharpness` stands for n k together.
///
/// Transitions, by `transition`: "uniform", as the thesis has them; or "neighbours": the state stays, or goes on to
/// nodes linked with it, but for a share `teleport` that may go anywhere, and from "no loop" so may a share `teleport`.

#pragma once

#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/place_graph.h"

namespace gaitcam {

struct LoopFilterOptions {
  using DescribedTag = void;
  double threshold = 2.1;  ///< Of similarity, 1 being a coin toss's (SimilarityOf).
  std::string likelihood = "bits";
  double sharpness = 60;
  std::string transition = "neighbours";
  double teleport = 0.3;
};

template <class Visitor>
void VisitFields(Visitor& visit, LoopFilterOptions& o) {
  visit("threshold", o.threshold, Between(1.0, 1000.0), "least similarity of a view with the place it shows");
  visit("likelihood", o.likelihood, OneOf({"bits", "similarity"}), "how similarity becomes likelihood");
  visit("sharpness", o.sharpness, Between(0.1, 10000.0), "of likelihoods by bits");
  visit("transition", o.transition, OneOf({"uniform", "neighbours"}), "where the state may go between two tests");
  visit("teleport", o.teleport, Between(1e-6, 1.0), "share of transitions that lead anywhere");
}

class LoopFilter {
 public:
  explicit LoopFilter(const LoopFilterOptions& options = {});

  struct Belief {
    std::vector<double> likelihood;  ///< Of "no loop", then of each node; 0 for the one left out.
    std::vector<double> posterior;   ///< Likewise; sum 1.
    int best = -1;                   ///< Eq. 4.5: the most probable node, or -1.
  };

  /// One step of Eq. 4.6. @param similarity of each node; there may be more nodes than before. @param left_out of each
  /// node, whether it cannot be. @param links between nodes. @pre as many of both; no fewer than before.
  Belief Update(const std::vector<double>& similarity, const std::vector<bool>& left_out,
                const std::vector<PlaceLink>& links);
  /// Forgets: before the next step nothing is known.
  void Reset() { belief_.clear(); }

 private:
  std::vector<double> Predict(size_t states, const std::vector<PlaceLink>& links) const;
  double Likelihood(double similarity) const;

  LoopFilterOptions options_;
  std::vector<double> belief_;
};

}  // namespace gaitcam
