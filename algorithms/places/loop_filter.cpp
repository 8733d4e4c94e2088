#include "algorithms/places/loop_filter.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {

LoopFilter::LoopFilter(const LoopFilterOptions& options) : options_(options) { CheckFields(options, "loop."); }

double LoopFilter::Likelihood(double similarity) const {
  if (options_.likelihood == LoopLikelihood::kSimilarity) return similarity;
  return std::exp(options_.sharpness * (0.5 / options_.threshold - 0.5 / std::max(similarity, 0.5)));
}

std::vector<double> LoopFilter::Predict(size_t states, const std::vector<PlaceLink>& links) const {
  std::vector<double> predicted(states, 1.0 / double(states));
  if (belief_.empty() || options_.transition == LoopTransition::kUniform) return predicted;
  std::vector<std::vector<size_t>> successors(states);  // states that may follow
  for (size_t i = 0; i < states; ++i) successors[i] = {i};
  for (const PlaceLink& link : links) {
    const auto add = [&](size_t from, size_t to) {  // once, however many links there are
      if (std::find(successors[from].begin(), successors[from].end(), to) == successors[from].end())
        successors[from].push_back(to);
    };
    add(size_t(link.from) + 1, size_t(link.to) + 1);
    add(size_t(link.to) + 1, size_t(link.from) + 1);
  }
  for (double& p : predicted) p *= options_.teleport;
  for (size_t i = 0; i < belief_.size(); ++i) {
    for (const size_t to : successors[i])
      predicted[to] += (1 - options_.teleport) * belief_[i] / double(successors[i].size());
  }
  return predicted;
}

LoopFilter::Belief LoopFilter::Update(const std::vector<double>& similarity, const std::vector<bool>& left_out,
                                      const std::vector<PlaceLink>& links) {
  const size_t states = similarity.size() + 1;
  GAITCAM_ASSERT(belief_.size() <= states && left_out.size() == similarity.size());
  Belief belief;
  belief.likelihood = {options_.likelihood == LoopLikelihood::kSimilarity ? options_.threshold : 1.0};
  for (size_t i = 0; i < similarity.size(); ++i)
    belief.likelihood.push_back(left_out[i] ? 0 : Likelihood(similarity[i]));
  belief.posterior = Predict(states, links);
  double sum = 0;
  for (size_t i = 0; i < states; ++i) sum += belief.posterior[i] *= belief.likelihood[i];
  for (double& p : belief.posterior) p /= sum;
  // The first of equals: "no loop" rather than a node.
  belief.best = int(std::max_element(belief.posterior.begin(), belief.posterior.end()) - belief.posterior.begin()) - 1;
  belief_ = belief.posterior;
  return belief;
}

}  // namespace gaitcam
