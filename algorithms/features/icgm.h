/// Incremental Center of Gravity Matching: which matches between two images belong to what stands still.
///
/// Source: Hua, section 4.1. Between two near views the vectors from one static point to others change little, and
/// those to what moved, or was matched wrongly, change much. A match is judged by the vector to it from the centre of
/// gravity of the matches that are kept already.

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"

namespace gaitcam {

/// Where a match's two key points lie, px, in images of one size.
struct MatchedPosition {
  Eigen::Vector2d a{0, 0}, b{0, 0};
};

/// In the order of the matches.
std::vector<MatchedPosition> PositionsOf(const std::vector<Match>& matches, const Features& a, const Features& b);

/// Ratio of difference, |x - y| / (|x| + |y|) (Hua, Eq. 4.19): 0 for equal vectors, also if both are 0; at most 1.
double RatioOfDifference(const Eigen::Vector2d& x, const Eigen::Vector2d& y);

/// How the matches that stand still are found.
enum class IcgmStart {
  kRandomPair,  ///< Hua, Algorithm 1: grows from a random pair of matches whose vector hardly changed.
  kConsensus,   ///< Ours: every pair is a start. See FilterByGravity.
};
constexpr auto WordsOf(IcgmStart) {
  return std::array{EnumWord{IcgmStart::kRandomPair, "random_pair"}, EnumWord{IcgmStart::kConsensus, "consensus"}};
}

struct IcgmOptions {
  using DescribedTag = void;
  IcgmStart start = IcgmStart::kRandomPair;
  double threshold = 0.08;  ///< Hua, section 5.1; 0.075 and 0.082 in 5.2 and 5.3.
  bool automatic = false;
  int max_draws = 10000;
  double noise_px = 2;
  int neighbours = 12;
  int agreeing = 5;
  double near_threshold = 0.05;
  double centre_threshold = 0.01;

  /// With the consensus of all pairs. The threshold was chosen on scenes and seeds of which no result is reported.
  static IcgmOptions Consensus();
};

template <class Visitor>
void VisitFields(Visitor& visit, IcgmOptions& o) {
  visit("start", o.start, EnumWords<IcgmStart>(), "from what the set of kept matches grows: one random pair, or all");
  visit("threshold", o.threshold, Between(0, 1), "largest ratio of difference of a kept match; 1 keeps all");
  visit("automatic", o.automatic, Nested(), "a threshold of its own for each pair of images");
  visit("max_draws", o.max_draws, AtLeast(1), "random_pair: pairs drawn before nothing is kept");
  visit("noise_px", o.noise_px, AtLeast(0), "consensus: vectors may differ by so much beside the threshold");
  visit("neighbours", o.neighbours, AtLeast(1), "consensus: nearest kept matches that a match is compared with");
  visit("agreeing", o.agreeing, AtLeast(1), "consensus: so many of the neighbours, or their share, agree");
  visit("near_threshold", o.near_threshold, Between(0, 1), "consensus: largest ratio of difference to a neighbour");
  visit("centre_threshold", o.centre_threshold, Between(0, 1),
        "consensus: largest ratio of difference to the centre of gravity of the neighbours that agree");
}

struct IcgmResult {
  std::vector<int> kept;  ///< Indices of the matches that belong to what stands still, ascending. May be empty.
  double threshold = 0;   ///< That was applied.
};

/// Start random_pair is Hua's Algorithm 1; its first two matches are kept, too. In the order of the matches, each is
/// kept whose ratio is within the threshold, and moves the centre.
///
/// Start consensus depends on no order and no draw. (1) Two matches agree if the vectors between them do; the match
/// that agrees with fewest is taken out until each agrees with half of those that are left. (2) Parallax differs by
/// depth, so that far matches say little. A match is kept that agrees with half of those, and closely with `agreeing`
/// of its `neighbours` nearest among them, and with these neighbours' centre of gravity more closely still. Twice, so
/// that who was taken out by mistake can return.
///
/// Time is quadratic in the number of matches.
/// @param random draws the start of random_pair.
/// @throws BadInput for fewer than 2 matches, or a position that is not finite.
IcgmResult FilterByGravity(const std::vector<MatchedPosition>& matches, const IcgmOptions& options,
                           RandomStream& random);

/// Those of `matches` that are kept, in their order; none of fewer than 2.
std::vector<Match> FilterByGravity(const std::vector<Match>& matches, const Features& a, const Features& b,
                                   const IcgmOptions& options, RandomStream& random);

/// The threshold for a pair of images by its own ratios of difference, from the centre of gravity of those that agree.
/// Key points paired at random say how ratios of wrong matches are distributed; how many matches have greater ratios
/// than half of these says how many are wrong (Storey, J. R. Stat. Soc. B 64, 2002). From both follow the precision and
/// recall to be expected of every threshold: it is the least whose F1 is within 0.02 of the best one's. People who walk
/// are not wrong at random, so some of them pass.
/// @pre 2 matches or more, all finite.
double AutomaticThreshold(const std::vector<MatchedPosition>& matches, const IcgmOptions& options);

}  // namespace gaitcam
