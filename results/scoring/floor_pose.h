/// How a system that maps the floor sees it: where its normal points, and how high the camera is above it.
///
/// The system's world has the floor at z = 0 as the true one has, so nothing is aligned: attitude and height are what
/// the system says they are.

#pragma once

#include <vector>

#include "results/scoring/association.h"
#include "results/scoring/metric.h"

namespace gaitcam {

struct FloorPoseMeasures {
  std::vector<double> normal_deg;  ///< Per pair: angle between estimated and true normal, both seen by the camera.
  std::vector<double> height_m;    ///< Estimated minus true height of the camera.
};
FloorPoseMeasures MeasureFloorPoses(const std::vector<PosePair>& pairs);

std::vector<Metric<FloorPoseMeasures>> FloorPoseMetrics();

}  // namespace gaitcam
