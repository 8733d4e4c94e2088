/// Which matches between two views are believed before geometry sees them, as an option of an odometry.
///
/// Source: Hua, section 6.2: an odometry by epipolar geometry whose matches are those that ICGM keeps.

#pragma once

#include <array>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/features/icgm.h"

namespace gaitcam {

enum class MatchFilterKind {
  kNone,
  kIcgm,       ///< Hua, Algorithm 1.
  kConsensus,  ///< Ours. See FilterByGravity.
};
constexpr auto WordsOf(MatchFilterKind) {
  return std::array{EnumWord{MatchFilterKind::kNone, "none"}, EnumWord{MatchFilterKind::kIcgm, "icgm"},
                    EnumWord{MatchFilterKind::kConsensus, "consensus"}};
}

struct MatchFilterOptions {
  using DescribedTag = void;
  MatchFilterKind filter = MatchFilterKind::kNone;
  double icgm_threshold = 0;
  bool icgm_automatic = false;

  /// @pre filter is not none.
  IcgmOptions Icgm() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, MatchFilterOptions& o) {
  visit("match_filter", o.filter, EnumWords<MatchFilterKind>(),
        "which matches are believed: all, those that ICGM keeps, those that a consensus of all pairs keeps");
  visit("icgm_threshold", o.icgm_threshold, Between(0, 1),
        "match_filter: largest ratio of difference of a kept match; 0: 0.08 of icgm, 0.12 of consensus");
  visit("icgm_automatic", o.icgm_automatic, Nested(), "match_filter: a threshold of its own for each pair of images");
}

/// In the order of `matches`. Without a filter all, and nothing is drawn; else fewer than 2 matches keep none.
/// @param random draws the start of icgm.
std::vector<Match> FilterMatches(const std::vector<Match>& matches, const Features& a, const Features& b,
                                 const MatchFilterOptions& options, RandomStream& random);

}  // namespace gaitcam
