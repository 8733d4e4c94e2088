/// A map of point landmarks: what a feature-based system knows of the world's geometry when it ends.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace gaitcam {

struct MapPoint {
  int64_t id = 0;                                 ///< Unique within the map.
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< In the world of the system's poses and in their unit: metres,
                                                  ///< unless the system is monocular and chooses its scale.
  std::optional<Eigen::Matrix3d> covariance;      ///< Of p_W, in W, unit squared; symmetric. Absent: not known.
  cv::Mat descriptor;                             ///< One row of CV_8U or CV_32F; empty: none is kept.
};

struct LandmarkMap {
  std::vector<MapPoint> points;
};

}  // namespace gaitcam
