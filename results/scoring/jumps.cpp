#include "results/scoring/jumps.h"

#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

double TurnedDeg(const Pose& X) { return kDegPerRad * RotationAngle(Eigen::Quaterniond::Identity(), X.rotation); }

}  // namespace

std::vector<Jump> FindJumps(const std::vector<PosePair>& pairs, const JumpRule& rule) {
  std::vector<Jump> jumps;
  for (size_t i = 1; i < pairs.size(); ++i) {
    const Pose truth = pairs[i - 1].truth.Inverse() * pairs[i].truth;
    const Pose error = truth.Inverse() * (pairs[i - 1].estimate.Inverse() * pairs[i].estimate);
    const Jump step{i, error.translation.norm(), TurnedDeg(error)};
    const bool is_jump = step.position_m > rule.position_m + rule.share * truth.translation.norm() ||
                         step.rotation_deg > rule.rotation_deg + rule.share * TurnedDeg(truth);
    if (is_jump) jumps.push_back(step);
  }
  return jumps;
}

}  // namespace gaitcam
