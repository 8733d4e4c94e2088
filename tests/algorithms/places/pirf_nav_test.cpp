#include "algorithms/places/pirf_nav.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "made_up_walk.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;

PirfNavOptions Options() {
  PirfNavOptions options;
  options.dictionary.max_distance = 0.5;  // words are about 1.4 apart, copies some 0.2
  return options;
}

TEST(PirfNav, NeighboursSupportOneAnotherByAGaussian) {
  const double g = std::exp(-0.5), two = std::exp(-2.0);
  const auto scores = internal::NeighbourhoodScores({0, 0, 6, 0, 0}, 2, 1);
  EXPECT_THAT(scores, ElementsAre(DoubleEq(6 * two / (1 + g + two)), DoubleEq(6 * g / (1 + 2 * g + two)),
                                  DoubleEq(6 / (1 + 2 * g + 2 * two)), DoubleEq(6 * g / (1 + 2 * g + two)),
                                  DoubleEq(6 * two / (1 + g + two))));
  EXPECT_THAT(internal::NeighbourhoodScores({3, 1, 2}, 0, 1), ElementsAre(3, 1, 2));
}

TEST(PirfNav, SupportOfEqualScoresIsThatScoreAtTheEndsToo) {
  for (const double score : internal::NeighbourhoodScores(std::vector<double>(7, 2.5), 3, 1.5))
    EXPECT_DOUBLE_EQ(score, 2.5);
}

TEST(PirfNav, SignificanceIsInDeviationsOfThoseFarOff) {
  // Without neighbours: all but the peak, 1 and 3 by turns, of mean 2 and deviation 1.
  EXPECT_DOUBLE_EQ(internal::Significance({1, 3, 1, 3, 9}, 4, 0, 0.1), 7);
  // One neighbour: places 2 to 4 share one with the peak's own sum.
  EXPECT_DOUBLE_EQ(internal::Significance({1, 3, 100, 100, 9, 50, 60}, 4, 1, 0.1), 7);
  EXPECT_DOUBLE_EQ(internal::Significance({0, 0, 0, 9}, 3, 0, 0.5), 18);  // the floor
  EXPECT_DOUBLE_EQ(internal::Significance({9}, 0, 0, 0.5), 18);
}

TEST(PirfNav, APlaceSeenAgainWinsAndOneNeverSeenIsNew) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    PirfNav memory(Options());
    const WalkTally tally = WalkTwice(memory, seed);
    EXPECT_EQ(tally.right, tally.places);
    EXPECT_EQ(tally.taken_for_known, 0);
  }
}

TEST(PirfNav, OneSharedWordIsNoPlace) {
  MadeUpWalk walk(30, 4);
  PirfNav memory(Options());
  for (int place = 0; place < 30; ++place) memory.Add(walk.See(place));
  Features view = walk.SeeElsewhere();
  view.descriptors.push_back(walk.See(12).descriptors.row(0));
  const PlaceAnswer answer = memory.Ask(view, 30);
  EXPECT_FALSE(answer.known);
  EXPECT_LT(answer.confidence, 1.5);  // about one floor; the same word is seen from the next places too
}

TEST(PirfNav, SaysWhatIsWrongInOneLine) {
  PirfNavOptions options;
  options.neighbour_sigma = 0;
  EXPECT_THAT(ErrorOf([&] { PirfNav{options}; }), HasSubstr("pirf_nav.neighbour_sigma"));
  PirfNav memory;
  MadeUpWalk walk(3, 6);
  memory.Add(walk.See(0));
  Features other = walk.See(1);
  other.descriptors = other.descriptors.colRange(0, 32).clone();
  EXPECT_THAT(ErrorOf([&] { memory.Ask(other, 1); }), HasSubstr("the dictionary has 64 columns"));
}

}  // namespace
}  // namespace gaitcam
