// What all memories of places have in common, and what two of them do beside it.

#include "algorithms/places/place_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/places/bag_of_words.h"
#include "algorithms/places/fab_map.h"
#include "algorithms/places/icgm_places.h"
#include "algorithms/places/pirf_nav.h"
#include "made_up_walk.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

/// Matches that move as most of them do: a filter that needs no threshold on these key points, which do not move at
/// all.
std::vector<Match> KeepUnmoved(const std::vector<Match>& matches, const Features& view, const Features& place) {
  std::vector<Match> kept;
  for (const Match& match : matches) {
    const cv::Point2f a = view.keypoints[size_t(match.a)].pt, b = place.keypoints[size_t(match.b)].pt;
    if (cv::norm(a - b) < 1) kept.push_back(match);
  }
  return kept;
}

DictionaryOptions Dictionary() {
  DictionaryOptions options;
  options.max_distance = 0.5;  // words are about 1.4 apart, copies some 0.2
  return options;
}

/// Learned from walks of other seeds.
FabMapModel Model() {
  std::vector<cv::Mat> training;
  for (uint64_t seed = 101; seed < 111; ++seed) {
    MadeUpWalk walk(MadeUpWalk::kMaxPlaces, seed);
    for (int place = 0; place < MadeUpWalk::kMaxPlaces; ++place) training.push_back(walk.See(place).descriptors);
  }
  return LearnFabMapModel(training, 500, 1);
}

const FabMapModel& TheModel() {
  static const FabMapModel model = Model();
  return model;
}

const std::vector<std::string> kMemories{"bag_of_words", "fab_map", "icgm_places", "pirf_nav"};

std::unique_ptr<PlaceMemory> Make(const std::string& name) {
  if (name == "bag_of_words") return std::make_unique<BagOfWords>(TheModel().vocabulary, TheModel().samples);
  if (name == "fab_map") return std::make_unique<FabMap>(TheModel());
  if (name == "icgm_places") return std::make_unique<IcgmPlaces>(KeepUnmoved, IcgmPlacesOptions{Dictionary()});
  return std::make_unique<PirfNav>(PirfNavOptions{Dictionary()});
}

TEST(PlaceMemory, APlaceSeenAgainWinsAndOneNeverSeenIsNew) {
  for (const std::string& name : kMemories) {
    const auto memory = Make(name);
    const WalkTally tally = WalkTwice(*memory, 1);
    EXPECT_GE(tally.best, 0.95 * tally.places) << name;
    // Each by a threshold of its own, none of them tuned on these walks; fab_map's is that one of ten may be wrong.
    EXPECT_GE(tally.right, 0.8 * tally.places) << name;
    EXPECT_LE(tally.taken_for_known, name == "fab_map" ? 0.1 * tally.places : 0) << name;
    EXPECT_GT(memory->bytes_per_place(), 0) << name;
  }
}

TEST(PlaceMemory, ScoresAreOfTheFirstPlacesAndTheBestHasTheGreatest) {
  for (const std::string& name : kMemories) {
    const auto memory = Make(name);
    MadeUpWalk walk(20, 2);
    for (int place = 0; place < 20; ++place) memory->Add(walk.See(place));
    EXPECT_EQ(memory->size(), 20u) << name;
    for (const int place : {3, 9, 15}) {
      const PlaceAnswer answer = memory->Ask(walk.See(place), 12);
      ASSERT_EQ(answer.score.size(), 12u) << name;
      EXPECT_GE(*std::min_element(answer.score.begin(), answer.score.end()), 0) << name;
      EXPECT_LT(answer.place, 12) << name;
      EXPECT_EQ(answer.known, place < 12) << name;
      if (place < 12) EXPECT_NEAR(answer.place, place, 1) << name;
    }
  }
}

TEST(PlaceMemory, AnEmptyMemoryAndAnEmptyViewHaveNoPlace) {
  for (const std::string& name : kMemories) {
    const auto memory = Make(name);
    MadeUpWalk walk(5, 3);
    EXPECT_EQ(memory->bytes_per_place(), 0) << name;
    EXPECT_FALSE(memory->Ask(walk.See(0), 0).known) << name;
    EXPECT_EQ(memory->Ask(walk.See(0), 0).place, -1) << name;
    for (int place = 0; place < 5; ++place) memory->Add(walk.See(place));
    memory->Add(Features());
    EXPECT_EQ(memory->size(), 6u) << name;
    EXPECT_FALSE(memory->Ask(Features(), 5).known) << name;
  }
}

TEST(PlaceMemory, SameViewsGiveTheSameAnswersToTheBit) {
  for (const std::string& name : kMemories) {
    const auto a = Make(name), b = Make(name);
    for (PlaceMemory* memory : {a.get(), b.get()}) {
      MadeUpWalk walk(10, 4);
      for (int place = 0; place < 10; ++place) memory->Add(walk.See(place));
    }
    MadeUpWalk walk(10, 4);
    const Features view = walk.See(6);
    const PlaceAnswer first = a->Ask(view, 10), second = b->Ask(view, 10);
    EXPECT_EQ(first.score, second.score) << name;
    EXPECT_EQ(first.confidence, second.confidence) << name;
  }
}

TEST(PlaceMemory, DescriptorsOfAnotherLengthAreRefusedInOneLine) {
  for (const std::string& name : kMemories) {
    const auto memory = Make(name);
    MadeUpWalk walk(5, 3);
    memory->Add(walk.See(0));
    Features other = walk.See(1);
    other.descriptors = other.descriptors.colRange(0, 32).clone();
    EXPECT_THAT(ErrorOf([&] { memory->Add(other); }), HasSubstr("of 32 columns (float); the")) << name;
    EXPECT_THAT(ErrorOf([&] { memory->Ask(other, 1); }), HasSubstr("has 64 columns (float)")) << name;
    EXPECT_EQ(memory->size(), 1u) << name;
  }
}

TEST(IcgmPlaces, OnlyMatchesThatBelongTogetherVote) {
  MadeUpWalk walk(20, 5);
  IcgmPlaces filtered(KeepUnmoved, IcgmPlacesOptions{Dictionary()}), blind(nullptr, IcgmPlacesOptions{Dictionary()});
  for (int place = 0; place < 20; ++place) {
    const Features view = walk.See(place);
    filtered.Add(view);
    blind.Add(view);
  }
  Features view = walk.See(7);
  const PlaceAnswer before = filtered.Ask(view, 20);
  EXPECT_NEAR(before.place, 7, 1);
  EXPECT_TRUE(before.known);
  // The same things, each somewhere else: as descriptors they match, as a picture they do not.
  for (size_t k = 0; k < view.keypoints.size(); ++k) view.keypoints[k].pt.x += float(10 + 7 * k);
  EXPECT_FALSE(filtered.Ask(view, 20).known);
  EXPECT_TRUE(blind.Ask(view, 20).known);
}

TEST(IcgmPlaces, ByIcgmAPlaceIsKnownAndItsThingsInDisorderAreNot) {
  MadeUpWalk walk(20, 5);
  IcgmPlaces memory(GravityFilter({}, 1), IcgmPlacesOptions{Dictionary()});
  for (int place = 0; place < 20; ++place) memory.Add(walk.See(place));
  Features view = walk.See(7);
  EXPECT_TRUE(memory.Ask(view, 20).known);
  EXPECT_NEAR(memory.Ask(view, 20).place, 7, 1);
  RandomStream random(3, "disorder");
  for (cv::KeyPoint& point : view.keypoints) point.pt = {float(random.Uniform(0, 320)), float(random.Uniform(0, 240))};
  EXPECT_FALSE(memory.Ask(view, 20).known);
}

TEST(IcgmPlaces, OnlyCandidatesGetVotes) {
  MadeUpWalk walk(20, 6);
  IcgmPlacesOptions options{Dictionary()};
  options.candidates = 2;
  IcgmPlaces memory(KeepUnmoved, options);
  for (int place = 0; place < 20; ++place) memory.Add(walk.See(place));
  const PlaceAnswer answer = memory.Ask(walk.See(10), 20);
  EXPECT_EQ(std::count_if(answer.score.begin(), answer.score.end(), [](double votes) { return votes > 0; }), 2);
  EXPECT_EQ(answer.confidence, answer.score[size_t(answer.place)]);
  options.votes = 0;
  EXPECT_THAT(ErrorOf([&] { IcgmPlaces(KeepUnmoved, options); }), HasSubstr("icgm_places.votes"));
}

TEST(BagOfWords, SimilarityOfAViewWithItselfIsOne) {
  BagOfWords memory(TheModel().vocabulary, TheModel().samples);
  MadeUpWalk walk(5, 7);
  const Features view = walk.See(2);
  memory.Add(walk.See(1));
  memory.Add(view);
  const PlaceAnswer answer = memory.Ask(view, 2);
  EXPECT_EQ(answer.place, 1);
  EXPECT_NEAR(answer.confidence, 1, 1e-6);  // weights are kept as float
  EXPECT_LT(answer.score[0], 1);
  EXPECT_THAT(ErrorOf([] { BagOfWords(cv::Mat(), {}); }), HasSubstr("the vocabulary is empty"));
}

}  // namespace
}  // namespace gaitcam
