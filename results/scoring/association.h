/// Association of an estimate's poses with true poses by time stamps.

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

/// Each pose in at most one pair; or the nearest stamp for each, as evo does it. See Associate.
enum class AssociationRule { kOneToOne, kNearest };
constexpr auto WordsOf(AssociationRule) {
  return std::array{EnumWord{AssociationRule::kOneToOne, "one_to_one"}, EnumWord{AssociationRule::kNearest, "nearest"}};
}

struct AssociationOptions {
  using DescribedTag = void;

  AssociationRule rule = AssociationRule::kOneToOne;
  double max_difference_ms = 10.0;
  double time_offset_ms = 0.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, AssociationOptions& o) {
  visit("rule", o.rule, EnumWords<AssociationRule>(), "each pose in at most one pair, or the nearest stamp for each");
  visit("max_difference_ms", o.max_difference_ms, Between(0.0, 1e6), "stamps further apart form no pair");
  visit("time_offset_ms", o.time_offset_ms, Between(-1e9, 1e9), "added to the estimate's stamps first");
}

/// Indices of an associated pair.
struct IndexPair {
  size_t truth = 0;
  size_t estimate = 0;
  bool operator==(const IndexPair&) const = default;
};

/// Pairs of indices, in time order. Stamps must increase strictly.
///
/// "one_to_one": no index appears twice, no two pairs cross in time, and of all such choices the one that maximises the
/// sum of (max_difference - |difference|) is taken, ties going to the larger number of pairs. So a missing stamp never
/// shifts its neighbours on to worse partners.
///
/// "nearest": each stamp of the shorter list (the estimate's, if equally long) takes the nearest of the longer one, the
/// earlier if two are equally near; an entry of the longer list may be taken twice. This is evo's rule (sync.py).
/// @throws BadOption for a field out of range.
std::vector<IndexPair> Associate(const std::vector<int64_t>& truth_ns, const std::vector<int64_t>& estimate_ns,
                                 const AssociationOptions& options);

/// True and estimated pose of one instant.
struct PosePair {
  int64_t stamp_ns = 0;    ///< The truth's stamp.
  Pose truth;              ///< X_WC
  Pose estimate;           ///< X_VC, V being the estimator's world.
  bool restarted = false;  ///< The estimator started a new world since the pair before.
};

/// Pairs the estimate's poses with the truth's. A restart at a frame that finds no partner is carried to the next pair.
/// @throws BadInput if stamps of either do not increase.
std::vector<PosePair> AssociatePoses(const Estimate& estimate, const Trajectory& truth,
                                     const AssociationOptions& options);

}  // namespace gaitcam
