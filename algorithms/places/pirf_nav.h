/// PIRF-nav 2.0: N. Tongprasit, A. Kawewong and O. Hasegawa, "PIRF-Nav 2: speeded-up online and incremental
/// appearance-based SLAM in highly dynamic environment", IEEE Workshop on Applications of Computer Vision, 2011; as Hua
/// describes it (2.2, Fig. 2.4), who compares with it (Table 5.1) and builds on it (4.2). Descriptors are those of
/// PIRFs there; any robust features will do.
///
/// Hua gives no equations. What stands here:
/// 1. A view's features are found in the dictionary (incremental_dictionary.h); each place i gets the score s_i.
/// 2. Neighbourhood: places follow each other along the way, so where one shows the view its neighbours nearly do.
///      beta_i = sum_k g(k - i) s_k / sum_k g(k - i),  |k - i| <= neighbours,  g a Gaussian of the distance in places.
/// 3. Significance of the peak: it stands out against all places that are not its neighbours,
///      z = (beta_max - mean beta) / max(deviation of beta, g(0) log(N) / sum_k g(k)).
///    The floor is what a single word adds to beta that one place alone shows: on a map where hardly anything else
///    matches, the deviation is next to nothing and one chance match would be a significant peak.
/// 4. The place is the one of greatest s_i among the peak's neighbours.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/places/incremental_dictionary.h"
#include "algorithms/places/place_memory.h"

namespace gaitcam {

struct PirfNavOptions {
  using DescribedTag = void;
  DictionaryOptions dictionary;
  int neighbours = 2;
  double neighbour_sigma = 1;
  double significance = 8;
};

template <class Visitor>
void VisitFields(Visitor& visit, PirfNavOptions& o) {
  visit("dictionary", o.dictionary, Nested(), "words are learned along the way");
  visit("neighbours", o.neighbours, Between(0, 100), "places before and after, whose scores support one another");
  visit("neighbour_sigma", o.neighbour_sigma, Positive(), "of the support's Gaussian, in places");
  visit("significance", o.significance, AtLeast(0), "deviations by which a recognised place stands out");
}

class PirfNav : public PlaceMemory {
 public:
  /// @throws BadOption.
  explicit PirfNav(const PirfNavOptions& options = {});

  void Add(const Features& view) override;
  /// score: beta; confidence: z.
  PlaceAnswer Ask(const Features& view, size_t first_places) override;
  size_t size() const override { return dictionary_.places(); }
  double bytes_per_place() const override;
  const IncrementalDictionary& dictionary() const { return dictionary_; }

 private:
  PirfNavOptions options_;
  IncrementalDictionary dictionary_;
};

namespace internal {

/// Step 2.
std::vector<double> NeighbourhoodScores(const std::vector<double>& scores, int neighbours, double sigma);

/// Step 3: z of place `peak`. @param floor of the deviation, > 0.
double Significance(const std::vector<double>& scores, size_t peak, int neighbours, double floor);

}  // namespace internal

}  // namespace gaitcam
