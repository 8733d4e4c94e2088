/// The appearance SLAM of Hua 4.2: places are known by robust features, found by an incremental dictionary as in
/// PIRF-nav 2.0, and loops are verified by the geometry of the matches.
///
/// "ICGM can not only be used to extract features but also to detect loop-closure" (4.2). The dictionary's matching
/// score names candidates, of which Hua takes the three best (6.1.1.2); the view's features are matched with each
/// candidate's, and each match that the filter keeps is a vote for it. The filter is a parameter: ICGM there; anything
/// that tells which matches of two images belong together will do, and one that keeps all makes it a vote of
/// descriptors alone. Features are extracted before: of two images (single-directional) or three (double-directional).

#pragma once

#include <cstdint>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/icgm.h"
#include "algorithms/features/pirf.h"
#include "algorithms/places/incremental_dictionary.h"
#include "algorithms/places/place_memory.h"

namespace gaitcam {

struct IcgmPlacesOptions {
  using DescribedTag = void;
  DictionaryOptions dictionary;
  int candidates = 3;
  double ratio = 0.8;
  int votes = 12;
};

template <class Visitor>
void VisitFields(Visitor& visit, IcgmPlacesOptions& o) {
  visit("dictionary", o.dictionary, Nested(), "words are learned along the way");
  visit("candidates", o.candidates, Between(1, 1000), "places of the best matching score, whose features are matched");
  visit("ratio", o.ratio, Between(0.1, 1.0), "of a match: nearest over second nearest distance");
  visit("votes", o.votes, AtLeast(1), "matches kept from which on a place is recognised");
}

class IcgmPlaces : public PlaceMemory {
 public:
  /// @param filter is called with two matches or more; null keeps all. @throws BadOption.
  explicit IcgmPlaces(MatchFilter filter, const IcgmPlacesOptions& options = {});

  void Add(const Features& view) override;
  /// score: votes, 0 for places that are no candidates; confidence: votes of the best.
  PlaceAnswer Ask(const Features& view, size_t first_places) override;
  size_t size() const override { return places_.size(); }
  double bytes_per_place() const override;

 private:
  std::vector<size_t> Candidates(const Features& view, size_t first_places) const;
  size_t Votes(const Features& view, const Features& place) const;

  MatchFilter filter_;
  IcgmPlacesOptions options_;
  IncrementalDictionary dictionary_;
  std::vector<Features> places_;
};

/// ICGM as a filter. Its starts are drawn from a stream of their own.
MatchFilter GravityFilter(const IcgmOptions& options, uint64_t seed);

}  // namespace gaitcam
