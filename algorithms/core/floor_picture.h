/// The floor as seen from straight above: what a mapping system hands over, and what it is compared with.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace gaitcam {

/// One pixel per square cell; row 0 lies towards +y, column 0 towards -x.
struct FloorPicture {
  cv::Mat intensity;                                   ///< CV_8UC1; 0 where nothing was seen.
  cv::Mat sightings;                                   ///< CV_16UC1: how often each cell was seen; 0: never.
  double cell_m = 0;                                   ///< Side of a cell.
  Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  ///< x, y of the centre of the pixel in row 0, column 0.

  bool empty() const { return intensity.empty(); }
};

}  // namespace gaitcam
