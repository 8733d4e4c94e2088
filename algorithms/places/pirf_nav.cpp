#include "algorithms/places/pirf_nav.h"

#include <algorithm>
#include <cmath>

namespace gaitcam {
namespace {

/// g at distances 0 to `neighbours`.
std::vector<double> Support(int neighbours, double sigma) {
  std::vector<double> support;
  for (int k = 0; k <= neighbours; ++k) support.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  return support;
}

/// Weight of a place's own score in step 2, away from the ends of the way.
double OwnShare(int neighbours, double sigma) {
  const std::vector<double> support = Support(neighbours, sigma);
  double sum = support[0];
  for (size_t k = 1; k < support.size(); ++k) sum += 2 * support[k];
  return support[0] / sum;
}

struct Range {
  size_t begin, end;
};
Range Around(size_t place, int neighbours, size_t places) {
  const size_t reach = size_t(neighbours);
  return {place < reach ? 0 : place - reach, std::min(places, place + reach + 1)};
}

}  // namespace

namespace internal {

std::vector<double> NeighbourhoodScores(const std::vector<double>& scores, int neighbours, double sigma) {
  const std::vector<double> support = Support(neighbours, sigma);
  std::vector<double> supported;
  for (size_t i = 0; i < scores.size(); ++i) {
    const Range range = Around(i, neighbours, scores.size());
    double sum = 0, weights = 0;
    for (size_t k = range.begin; k < range.end; ++k) {
      const double weight = support[k < i ? i - k : k - i];
      sum += weight * scores[k];
      weights += weight;
    }
    supported.push_back(sum / weights);
  }
  return supported;
}

double Significance(const std::vector<double>& scores, size_t peak, int neighbours, double floor) {
  const Range near = Around(peak, 2 * neighbours, scores.size());  // whoever shares a place with the peak's sum
  double sum = 0, sum2 = 0, count = 0;
  for (size_t k = 0; k < scores.size(); ++k) {
    if (k >= near.begin && k < near.end) continue;
    sum += scores[k];
    sum2 += scores[k] * scores[k];
    ++count;
  }
  const double mean = count > 0 ? sum / count : 0;
  const double deviation = count > 0 ? std::sqrt(std::max(0.0, sum2 / count - mean * mean)) : 0;
  return (scores[peak] - mean) / std::max(deviation, floor);
}

}  // namespace internal

PirfNav::PirfNav(const PirfNavOptions& options) : options_(options), dictionary_(options.dictionary) {
  CheckFields(options, "pirf_nav.");
}

void PirfNav::Add(const Features& view) { dictionary_.AddPlace(KnownWords(dictionary_.Learn(view.descriptors))); }

PlaceAnswer PirfNav::Ask(const Features& view, size_t first_places) {
  PlaceAnswer answer;
  const std::vector<double> scores = dictionary_.Score(KnownWords(dictionary_.Find(view.descriptors)), first_places);
  answer.score = internal::NeighbourhoodScores(scores, options_.neighbours, options_.neighbour_sigma);
  const auto best = std::max_element(answer.score.begin(), answer.score.end());
  if (best == answer.score.end() || *best <= 0) return answer;
  const size_t peak = size_t(best - answer.score.begin());
  const double one_word = std::log(double(first_places)) * OwnShare(options_.neighbours, options_.neighbour_sigma);
  answer.confidence = internal::Significance(answer.score, peak, options_.neighbours, one_word);
  answer.known = answer.confidence >= options_.significance;
  const Range near = Around(peak, options_.neighbours, first_places);
  answer.place =
      int(std::max_element(scores.begin() + long(near.begin), scores.begin() + long(near.end)) - scores.begin());
  return answer;
}

double PirfNav::bytes_per_place() const { return size() == 0 ? 0 : double(dictionary_.bytes()) / double(size()); }

}  // namespace gaitcam
