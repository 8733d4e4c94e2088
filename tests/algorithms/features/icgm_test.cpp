#include "algorithms/features/icgm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "algorithms/core/random.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

constexpr double kWidth_px = 480, kHeight_px = 320;

Vector2d Anywhere(RandomStream& random) { return {random.Uniform(0, kWidth_px), random.Uniform(0, kHeight_px)}; }

/// Matches in a row: static ones, then those on somebody who walked, then wrong ones.
struct Street {
  std::vector<MatchedPosition> matches;
  int still = 0, walking = 0;

  bool IsStill(int i) const { return i < still; }
  bool IsWalking(int i) const { return i >= still && i < still + walking; }
};

/// @param zoom what a step ahead does to what stands still.
Street DrawStreet(int still, int walking, int wrong, uint64_t seed, double zoom = 1.04, double noise_px = 0.5) {
  RandomStream random(seed, "street");
  const auto noise = [&] { return Vector2d(random.Normal(0, noise_px), random.Normal(0, noise_px)); };
  const Vector2d middle(kWidth_px / 2, kHeight_px / 2), pan(12, -5);
  Street street;
  street.still = still;
  street.walking = walking;
  for (int i = 0; i < still; ++i) {
    const Vector2d a = Anywhere(random);
    street.matches.push_back({a, middle + zoom * (a - middle) + pan + noise()});
  }
  // Near the middle: far from all else, a walk of 98 px changes the vectors to it by less than a loose threshold
  // permits.
  const Vector2d person = middle + 0.5 * (Anywhere(random) - middle);
  for (int i = 0; i < walking; ++i) {
    const Vector2d a = person + Vector2d(random.Uniform(-25, 25), random.Uniform(-60, 60));
    street.matches.push_back({a, a + Vector2d(110, 8) + noise()});
  }
  for (int i = 0; i < wrong; ++i) street.matches.push_back({Anywhere(random), Anywhere(random)});
  return street;
}

std::vector<int> Kept(const std::vector<MatchedPosition>& matches, const IcgmOptions& options, uint64_t seed = 1) {
  RandomStream random(seed, "icgm");
  return FilterByGravity(matches, options, random).kept;
}

double F1(const Street& street, const std::vector<int>& kept) {
  const auto right = std::count_if(kept.begin(), kept.end(), [&](int i) { return street.IsStill(i); });
  return 2.0 * double(right) / double(int(kept.size()) + street.still);
}

TEST(RatioOfDifference, IsBetweenZeroAndOneAndKnowsNoScale) {
  EXPECT_EQ(RatioOfDifference({0, 0}, {0, 0}), 0);
  EXPECT_EQ(RatioOfDifference({3, 4}, {3, 4}), 0);
  EXPECT_EQ(RatioOfDifference({3, 4}, {-3, -4}), 1);
  EXPECT_EQ(RatioOfDifference({3, 4}, {0, 0}), 1);
  RandomStream random(1, "ratio");
  for (int i = 0; i < 200; ++i) {
    const Vector2d x = Anywhere(random) - Anywhere(random), y = Anywhere(random) - Anywhere(random);
    const double ratio = RatioOfDifference(x, y);
    EXPECT_LE(ratio, 1);
    EXPECT_GE(ratio, 0);
    EXPECT_EQ(ratio, RatioOfDifference(y, x));
    EXPECT_NEAR(ratio, RatioOfDifference(7 * x, 7 * y), 1e-12);
  }
}

/// Hua's Algorithm 1 as it is written, with the centres updated by SCG.
std::vector<int> Algorithm1(const std::vector<MatchedPosition>& p, double threshold, RandomStream& random) {
  const int n = int(p.size());
  int i = 0, j = 0;
  do {
    do {
      i = random.Index(n);
      j = random.Index(n);
    } while (i == j);
  } while (RatioOfDifference(p[size_t(i)].a - p[size_t(j)].a, p[size_t(i)].b - p[size_t(j)].b) > threshold);
  Vector2d cg0 = 0.5 * (p[size_t(i)].a + p[size_t(j)].a), cg1 = 0.5 * (p[size_t(i)].b + p[size_t(j)].b);
  double scg = 2;
  std::vector<int> robust{i, j};
  for (int k = 0; k < n; ++k) {
    if (k == i || k == j) continue;
    const MatchedPosition& m = p[size_t(k)];
    if (RatioOfDifference(cg0 - m.a, cg1 - m.b) > threshold) continue;
    cg0 = scg / (scg + 1) * (cg0 + m.a / scg);
    cg1 = scg / (scg + 1) * (cg1 + m.b / scg);
    ++scg;
    robust.push_back(k);
  }
  std::sort(robust.begin(), robust.end());
  return robust;
}

TEST(Icgm, IsAlgorithm1) {
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const Street street = DrawStreet(80, 15, 40, seed);
    RandomStream random(seed, "icgm");
    EXPECT_EQ(Kept(street.matches, {}, seed), Algorithm1(street.matches, IcgmOptions().threshold, random));
  }
}

TEST(Icgm, KeepsAllThatOnlyShiftsWhereverItStarts) {
  const Street street = DrawStreet(60, 0, 0, 4, 1, 0);
  IcgmOptions strict;
  strict.threshold = 1e-9;
  for (uint64_t seed = 1; seed <= 20; ++seed) EXPECT_EQ(Kept(street.matches, strict, seed).size(), 60u);
}

TEST(Icgm, AThresholdOfOneKeepsEverything) {
  const Street street = DrawStreet(20, 10, 50, 5);
  IcgmOptions all;
  all.threshold = 1;
  EXPECT_EQ(Kept(street.matches, all).size(), 80u);
}

TEST(Icgm, KeepsMoreTheLooserItIs) {
  const Street street = DrawStreet(100, 0, 60, 6);
  size_t before = 0;
  for (const double threshold : {0.02, 0.05, 0.1, 0.3, 1.0}) {
    IcgmOptions options;
    options.threshold = threshold;
    // The centre moves with what is kept, so that a looser threshold may drop one or two of the others.
    const size_t now = Kept(street.matches, options, 2).size();
    EXPECT_GE(now + 2, before) << threshold;
    before = now;
  }
}

TEST(Icgm, NoPairThatAgreesIsNothingKept) {
  IcgmOptions options;
  options.threshold = 0.01;
  EXPECT_TRUE(Kept({{{0, 0}, {0, 0}}, {{100, 0}, {0, 100}}, {{0, 100}, {-100, 0}}}, options).empty());
}

TEST(Icgm, ARandomStartCanFallOnSomebodyAndTheConsensusCannot) {
  int fell = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const Street street = DrawStreet(60, 30, 10, seed);
    const std::vector<int> faithful = Kept(street.matches, {}, seed);
    fell += F1(street, faithful) < 0.5;
    const std::vector<int> ours = Kept(street.matches, IcgmOptions::Consensus());
    // 60 matches are few: at the border the neighbours' centre lies so far aside that the zoom moves it by 3 px.
    EXPECT_GT(F1(street, ours), 0.85) << seed;
    for (const int i : ours) EXPECT_FALSE(street.IsWalking(i)) << seed;
  }
  EXPECT_GT(fell, 0);
  EXPECT_LT(fell, 20);
}

TEST(Icgm, TheConsensusDropsWrongMatchesThatTheCentreLetsPass) {
  int by_centre = 0, by_consensus = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Street street = DrawStreet(150, 0, 150, 100 + seed);
    const auto wrong = [&](const std::vector<int>& kept) {
      return int(std::count_if(kept.begin(), kept.end(), [&](int i) { return !street.IsStill(i); }));
    };
    by_centre += wrong(Kept(street.matches, {}, seed));
    const std::vector<int> ours = Kept(street.matches, IcgmOptions::Consensus());
    by_consensus += wrong(ours);
    EXPECT_GT(F1(street, ours), 0.97) << seed;
  }
  // A ratio of 0.08 at 150 px from the centre permits 24 px: of 1500 anywhere in 480 x 320 px, 1 % pass.
  EXPECT_GT(by_centre, 10);
  EXPECT_LT(by_consensus, by_centre / 3);
}

TEST(Icgm, TheConsensusDependsOnNoOrderAndNoShift) {
  const Street street = DrawStreet(80, 20, 40, 7);
  const std::vector<int> kept = Kept(street.matches, IcgmOptions::Consensus());
  std::vector<MatchedPosition> reversed(street.matches.rbegin(), street.matches.rend());
  for (MatchedPosition& match : reversed) {
    match.a += Vector2d(64, -32);  // exact in binary: sums round as before
    match.b += Vector2d(-128, 16);
  }
  std::vector<int> back;
  for (const int i : Kept(reversed, IcgmOptions::Consensus())) back.push_back(int(reversed.size()) - 1 - i);
  std::reverse(back.begin(), back.end());
  EXPECT_EQ(back, kept);
}

TEST(Icgm, TheAutomaticThresholdIsAsGoodAsTheBestFixedOneWhereWrongMatchesAreRandom) {
  for (const double zoom : {1.02, 1.1}) {
    for (const int wrong : {20, 100, 200}) {
      double automatic = 0, best = 0;
      std::vector<double> fixed(40, 0);
      for (uint64_t seed = 1; seed <= 8; ++seed) {
        const Street street = DrawStreet(150, 0, wrong, 200 + seed, zoom);
        IcgmOptions options;
        options.automatic = true;
        automatic += F1(street, Kept(street.matches, options, seed)) / 8;
        options.automatic = false;
        for (size_t k = 0; k < fixed.size(); ++k) {
          options.threshold = 0.01 * double(k + 1);
          fixed[k] += F1(street, Kept(street.matches, options, seed)) / 8;
        }
      }
      best = *std::max_element(fixed.begin(), fixed.end());
      EXPECT_GT(automatic, best - 0.03) << "zoom " << zoom << ", " << wrong << " wrong";
    }
  }
}

TEST(Icgm, TheAutomaticThresholdFollowsTheMotion) {
  IcgmOptions options;
  EXPECT_LT(AutomaticThreshold(DrawStreet(150, 0, 100, 9, 1.01).matches, options),
            AutomaticThreshold(DrawStreet(150, 0, 100, 9, 1.25).matches, options));
}

TEST(Icgm, FewMatchesDoNoHarm) {
  for (int n = 2; n < 12; ++n) {
    const Street street = DrawStreet(n, 0, 0, uint64_t(n));
    for (IcgmOptions options : {IcgmOptions(), IcgmOptions::Consensus()}) {
      options.automatic = true;
      EXPECT_LE(Kept(street.matches, options).size(), size_t(n));
    }
    EXPECT_EQ(Kept(std::vector<MatchedPosition>(size_t(n)), {}).size(), size_t(n));  // all in one place
  }
}

TEST(Icgm, RefusesWhatIsNoSetOfMatchesInOneLine) {
  EXPECT_THAT(ErrorOf([] { Kept({}, {}); }), HasSubstr("0 matches; expected 2 or more"));
  EXPECT_THAT(ErrorOf([] { Kept({{{1, 1}, {2, 2}}}, {}); }), HasSubstr("1 match; expected 2 or more"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf([&] { Kept({{{1, 1}, {2, 2}}, {{1, nan}, {2, 2}}}, {}); }), HasSubstr("match 1 lies nowhere"));
}

}  // namespace
}  // namespace gaitcam
