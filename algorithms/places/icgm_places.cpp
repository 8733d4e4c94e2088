#include "algorithms/places/icgm_places.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gaitcam {

IcgmPlaces::IcgmPlaces(MatchFilter filter, const IcgmPlacesOptions& options)
    : filter_(std::move(filter)), options_(options), dictionary_(options.dictionary) {
  CheckFields(options, "icgm_places.");
}

void IcgmPlaces::Add(const Features& view) {
  dictionary_.AddPlace(KnownWords(dictionary_.Learn(view.descriptors)));
  places_.push_back({view.keypoints, view.descriptors.clone()});
}

/// Best first; of equal ones the earlier. None without a word in common.
std::vector<size_t> IcgmPlaces::Candidates(const Features& view, size_t first_places) const {
  const std::vector<double> scores = dictionary_.Score(KnownWords(dictionary_.Find(view.descriptors)), first_places);
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t(0));
  const size_t wanted = std::min(order.size(), size_t(options_.candidates));
  std::partial_sort(order.begin(), order.begin() + long(wanted), order.end(),
                    [&](size_t a, size_t b) { return scores[a] != scores[b] ? scores[a] > scores[b] : a < b; });
  order.resize(wanted);
  std::erase_if(order, [&](size_t place) { return scores[place] <= 0; });
  return order;
}

size_t IcgmPlaces::Votes(const Features& view, const Features& place) const {
  MatchingOptions matching;
  matching.ratio = options_.ratio;
  const std::vector<Match> matches = MatchDescriptors(view.descriptors, place.descriptors, matching);
  if (matches.size() < 2) return 0;
  return filter_ ? filter_(matches, view, place).size() : matches.size();
}

PlaceAnswer IcgmPlaces::Ask(const Features& view, size_t first_places) {
  PlaceAnswer answer;
  answer.score.assign(first_places, 0.0);
  for (const size_t place : Candidates(view, first_places)) {
    answer.score[place] = double(Votes(view, places_[place]));
    if (answer.score[place] <= answer.confidence) continue;
    answer.confidence = answer.score[place];
    answer.place = int(place);
  }
  answer.known = answer.confidence >= options_.votes;
  return answer;
}

MatchFilter GravityFilter(const IcgmOptions& options, uint64_t seed) {
  return [options, random = RandomStream(seed, "icgm_votes")](const std::vector<Match>& matches, const Features& view,
                                                              const Features& place) mutable {
    return FilterByGravity(matches, view, place, options, random);
  };
}

double IcgmPlaces::bytes_per_place() const {
  if (places_.empty()) return 0;
  size_t sum = dictionary_.bytes();
  for (const Features& place : places_) {
    sum += place.keypoints.capacity() * sizeof(cv::KeyPoint);
    sum += place.descriptors.total() * place.descriptors.elemSize();
  }
  return double(sum) / double(places_.size());
}

}  // namespace gaitcam
