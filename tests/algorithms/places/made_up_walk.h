/// A walk past things that come into sight and leave it, for tests of place memories.

#pragma once

#include "algorithms/places/place_memory.h"
#include "made_up_words.h"

namespace gaitcam {

/// Each place has 15 things of its own, which its two neighbours on either side show some of; 10 are everywhere. All
/// walks pass the same kinds of things, which the seed puts into another order.
class MadeUpWalk {
 public:
  static constexpr int kMaxPlaces = 40;

  MadeUpWalk(int places, uint64_t seed) : places_(places), random_(seed, "made_up_walk") {
    for (int kind = 0; kind < kKinds; ++kind) order_.push_back(kind);
    for (int k = 0; k < kKinds; ++k) std::swap(order_[size_t(k)], order_[size_t(k + random_.Index(kKinds - k))]);
  }

  /// Two of three things that are there.
  Features See(int place) {
    std::vector<int> rows = SeeWhatIsEverywhere();
    for (int other = std::max(0, place - 2); other <= std::min(places_ - 1, place + 2); ++other)
      See(kEverywhere + other * kOwn, kOwn / (1 << std::abs(other - place)), rows);
    return SeenRows(things_, rows, 0.15, random_);
  }
  /// What is everywhere, and things that no place has.
  Features SeeElsewhere() {
    std::vector<int> rows = SeeWhatIsEverywhere();
    See(kEverywhere + kMaxPlaces * kOwn, 2 * kOwn, rows);
    return SeenRows(things_, rows, 0.15, random_);
  }

 private:
  static constexpr int kEverywhere = 10, kOwn = 15, kKinds = kEverywhere + (kMaxPlaces + 2) * kOwn;

  void See(int first, int count, std::vector<int>& rows) {
    for (int thing = first; thing < first + count; ++thing) {
      if (random_.Uniform() < 0.67) rows.push_back(order_[size_t(thing)]);
    }
  }
  std::vector<int> SeeWhatIsEverywhere() {
    std::vector<int> rows;
    See(0, kEverywhere, rows);
    return rows;
  }

  cv::Mat things_ = UnitRows(kKinds, 64, 1);
  std::vector<int> order_;
  int places_;
  RandomStream random_;
};

struct WalkTally {
  int places = 0;
  int best = 0;             ///< Of the second walk: the answer is the place or a neighbour.
  int right = 0;            ///< ... and is accepted.
  int taken_for_known = 0;  ///< Of as many views from elsewhere.
};

inline WalkTally WalkTwice(PlaceMemory& memory, uint64_t seed) {
  WalkTally tally{MadeUpWalk::kMaxPlaces};
  MadeUpWalk walk(tally.places, seed);
  for (int place = 0; place < tally.places; ++place) memory.Add(walk.See(place));
  for (int place = 0; place < tally.places; ++place) {
    const PlaceAnswer answer = memory.Ask(walk.See(place), memory.size());
    const bool best = answer.place >= 0 && std::abs(answer.place - place) <= 1;
    tally.best += best;
    tally.right += best && answer.known;
    tally.taken_for_known += memory.Ask(walk.SeeElsewhere(), memory.size()).known;
  }
  return tally;
}

}  // namespace gaitcam
