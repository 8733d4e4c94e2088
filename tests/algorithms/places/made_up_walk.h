/// A walk past things that come into sight and leave it, for tests of place memories.

#pragma once

#include "algorithms/places/place_memory.h"
#include "made_up_words.h"

namespace gaitcam {

/// Each place has 15 things of its own, which its two neighbours on either side show some of; 10 are everywhere.
class MadeUpWalk {
 public:
  MadeUpWalk(int places, uint64_t seed)
      : things_(UnitRows(kEverywhere + (places + 2) * kOwn, 64, seed)),
        places_(places),
        random_(seed, "made_up_walk") {}

  /// Two of three things that are there, and an own or a neighbour's at that.
  Features See(int place) {
    std::vector<int> rows;
    for (int thing = 0; thing < kEverywhere; ++thing) See(thing, rows);
    for (int other = std::max(0, place - 2); other <= std::min(places_ - 1, place + 2); ++other) {
      for (int k = 0; k < kOwn / (1 << std::abs(other - place)); ++k) See(kEverywhere + other * kOwn + k, rows);
    }
    return SeenRows(things_, rows, 0.15, random_);
  }
  /// What is everywhere, and things that no place has.
  Features SeeElsewhere() {
    std::vector<int> rows;
    for (int thing = 0; thing < kEverywhere; ++thing) See(thing, rows);
    for (int k = 0; k < 2 * kOwn; ++k) See(kEverywhere + places_ * kOwn + k, rows);
    return SeenRows(things_, rows, 0.15, random_);
  }

 private:
  static constexpr int kEverywhere = 10, kOwn = 15;

  void See(int thing, std::vector<int>& rows) {
    if (random_.Uniform() < 0.67) rows.push_back(thing);
  }

  cv::Mat things_;
  int places_;
  RandomStream random_;
};

struct WalkTally {
  int places = 0;
  int right = 0;            ///< Of the second walk: accepted, and not farther off than a neighbour.
  int taken_for_known = 0;  ///< Of as many views from elsewhere.
};

inline WalkTally WalkTwice(PlaceMemory& memory, uint64_t seed) {
  WalkTally tally{40};
  MadeUpWalk walk(tally.places, seed);
  for (int place = 0; place < tally.places; ++place) memory.Add(walk.See(place));
  for (int place = 0; place < tally.places; ++place) {
    const PlaceAnswer answer = memory.Ask(walk.See(place), memory.size());
    tally.right += answer.known && std::abs(answer.place - place) <= 1;
    tally.taken_for_known += memory.Ask(walk.SeeElsewhere(), memory.size()).known;
  }
  return tally;
}

}  // namespace gaitcam
