#include "results/scoring/floor_pose.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/units.h"
#include "results/scoring/metrics.h"

namespace gaitcam {

FloorPoseMeasures MeasureFloorPoses(const std::vector<PosePair>& pairs) {
  FloorPoseMeasures measures;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d truth = pair.truth.R().transpose() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d estimate = pair.estimate.R().transpose() * Eigen::Vector3d::UnitZ();
    measures.normal_deg.push_back(kDegPerRad * std::atan2(truth.cross(estimate).norm(), truth.dot(estimate)));
    measures.height_m.push_back(pair.estimate.translation.z() - pair.truth.translation.z());
  }
  return measures;
}

std::vector<Metric<FloorPoseMeasures>> FloorPoseMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kMap;
  return {{"map_normal_rmse_deg", "deg", Better::kLower, kGroup,
           "angle between the floor's normal as estimated and the true one, root mean square",
           [](const auto& m) { return Summarize(m.normal_deg).rmse; }},
          {"map_camera_height_rmse_m", "m", Better::kLower, kGroup,
           "error of the camera's height above the floor, root mean square",
           [](const auto& m) { return Summarize(m.height_m).rmse; }},
          {"map_camera_height_error_m", "m", Better::kNearZero, kGroup, "how much too high the camera is, mean",
           [](const auto& m) { return Summarize(m.height_m).mean; }}};
}

}  // namespace gaitcam
