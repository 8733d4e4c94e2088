#include "algorithms/features/match_filter.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

IcgmOptions MatchFilterOptions::Icgm() const {
  GAITCAM_ASSERT(filter != MatchFilterKind::kNone);
  IcgmOptions options = filter == MatchFilterKind::kConsensus ? IcgmOptions::Consensus() : IcgmOptions();
  if (icgm_threshold > 0) options.threshold = icgm_threshold;
  options.automatic = icgm_automatic;
  return options;
}

std::vector<Match> FilterMatches(const std::vector<Match>& matches, const Features& a, const Features& b,
                                 const MatchFilterOptions& options, RandomStream& random) {
  if (options.filter == MatchFilterKind::kNone) return matches;
  return FilterByGravity(matches, a, b, options.Icgm(), random);
}

}  // namespace gaitcam
