/// Association of an estimate's poses with true poses by time stamps.

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/trajectory.h"

namespace gaitcam {

/// The truth at the estimate's own stamp; or pairs of stamps: each pose in at most one pair, or the nearest stamp for
/// each, as evo does it. See AssociatePoses and Associate.
enum class AssociationRule { kInterpolated, kOneToOne, kNearest };
constexpr auto WordsOf(AssociationRule) {
  return std::array{EnumWord{AssociationRule::kInterpolated, "interpolated"},
                    EnumWord{AssociationRule::kOneToOne, "one_to_one"}, EnumWord{AssociationRule::kNearest, "nearest"}};
}

struct AssociationOptions {
  using DescribedTag = void;

  AssociationRule rule = AssociationRule::kInterpolated;
  double max_gap_ms = 150.0;
  double max_difference_ms = 10.0;
  double time_offset_ms = 0.0;
};

template <class Visitor>
void VisitFields(Visitor& visit, AssociationOptions& o) {
  visit("rule", o.rule, EnumWords<AssociationRule>(),
        "the truth interpolated at each estimate's own stamp, each pose in at most one pair, or the nearest stamp");
  visit("max_gap_ms", o.max_gap_ms, Between(0.0, 1e6),
        "true poses further apart are not interpolated between: there the rule is one_to_one");
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
/// "one_to_one", and "interpolated" where there is nothing to interpolate between: no index appears twice, no two pairs
/// cross in time, and of all such choices the one that maximises the sum of (max_difference - |difference|) is taken,
/// ties going to the larger number of pairs. So a missing stamp never shifts its neighbours on to worse partners.
///
/// "nearest": each stamp of the shorter list (the estimate's, if equally long) takes the nearest of the longer one, the
/// earlier if two are equally near; an entry of the longer list may be taken twice. This is evo's rule (sync.py).
/// @throws BadOption for a field out of range.
std::vector<IndexPair> Associate(const std::vector<int64_t>& truth_ns, const std::vector<int64_t>& estimate_ns,
                                 const AssociationOptions& options);

/// True and estimated pose of one instant.
struct PosePair {
  int64_t stamp_ns = 0;                                   ///< The truth's.
  Pose truth;                                             ///< X_WC
  Pose estimate;                                          ///< X_VC, V being the estimator's world.
  std::optional<Matrix6d> covariance;                     ///< FrameEstimate::covariance.
  std::optional<Matrix6d> own_covariance = std::nullopt;  ///< FrameEstimate::own_covariance.
  CommonErrors common_errors = {};                        ///< FrameEstimate::common_errors.
};

/// Pairs an answer's poses with the truth's. "interpolated": each pose with the truth at its own instant
/// (SmoothPoseAt), so that an estimate which is late is compared with where the camera was when it says it was there; a
/// pose outside the truth's span, or in a gap of it longer than max_gap_ms, may still find a true pose within
/// max_difference_ms.
/// @throws BadInput if stamps of either do not increase.
std::vector<PosePair> AssociatePoses(const std::vector<FrameEstimate>& answer, const Trajectory& truth,
                                     const AssociationOptions& options);

}  // namespace gaitcam
