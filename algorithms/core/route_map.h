/// A map to find one's way by: views along taught ways, what each shows in space, and how they hang together.

#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose_graph.h"

namespace gaitcam {

/// Features of one view that stood still, with their depths.
struct MappedView {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;          ///< A row for each: CV_32FC1 or CV_8UC1; empty if there are none.
  std::vector<double> depth_m;  ///< Of each, along the optical axis.
};

/// Stamps of a later session go on by so much: clocks of simulated walks all begin alike.
inline constexpr int64_t kSessionApart_ns = 86'400'000'000'000;

struct RouteMap {
  CameraModel camera;
  std::string feature;              ///< Detector and descriptor, by name.
  Pose X_BC;                        ///< Maps points of the camera into the body that carried it (OdometryCalibration).
  PoseGraph graph;                  ///< Its world W is the first camera.
  std::vector<MappedView> views;    ///< Of each node, in their order; the last nodes may have none.
  std::vector<int> sessions = {0};  ///< The first node of each walk that taught it.
};

/// The session that a view is of, from 0.
inline int SessionOf(const RouteMap& map, int view) {
  return int(std::upper_bound(map.sessions.begin(), map.sessions.end(), view) - map.sessions.begin()) - 1;
}

}  // namespace gaitcam
