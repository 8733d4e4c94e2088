#include "models/code/people/crowd_entry.h"

namespace gaitcam {
namespace {

constexpr double kLeastHeight_m = 0.8, kMostHeight_m = 2.2;  // as PersonOptions has it
constexpr double kLongestStay_s = 3600, kLatest_s = 36000;

void CheckRange(const OptionValue& node, const std::string& key, const Eigen::Vector2d& range, double low, double high,
                const std::string& what) {
  if (range.allFinite() && range.x() >= low && range.y() >= range.x() && range.y() <= high) return;
  node.Child(key).Fail("expected [" + what + "], both from " + internal::NumberText(low) + " to " +
                       internal::NumberText(high));
}

}  // namespace

void ReadOption(const OptionValue& node, CrowdEntry& crowd) {
  if (!node.IsMap()) node.Fail("expected a map {count: ..., talking: ..., ...}");
  ReadFields(node, crowd);
  const double shares = crowd.standing + crowd.talking + crowd.sitting + crowd.queueing;
  if (shares > 1 + 1e-9) {
    node.Fail("standing, talking, sitting and queueing are " + internal::NumberText(shares) +
              " together; expected shares of 1 at most");
  }
  CheckRange(node, "stay_s", crowd.stay_s, 0, kLongestStay_s, "shortest, longest");
  CheckRange(node, "leave_s", crowd.leave_s, 0, kLatest_s, "first, last");
  CheckRange(node, "height_m", crowd.height_m, kLeastHeight_m, kMostHeight_m, "shortest, tallest");
  for (size_t i = 0; i < crowd.goals.size(); ++i) {
    if (!crowd.goals[i].allFinite()) node.Child("goals").Element(i).Fail("expected two finite numbers");
  }
}

}  // namespace gaitcam
