/// An occupancy grid: for each square cell of the ground plane, how probable it is that something stands there
/// (Thrun, Burgard, Fox, Probabilistic Robotics, 2005, chapter 9).

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>

namespace gaitcam {

/// Cells lie as those of a FloorPicture: row 0 towards +y, column 0 towards -x, in the plane z = 0 of the system's
/// world.
struct OccupancyGrid {
  cv::Mat log_odds;                                    ///< CV_32FC1, log(p / (1 - p)); 0 where nothing is known.
  double cell_m = 0;                                   ///< Side of a cell.
  Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  ///< x, y of the centre of the cell in row 0, column 0.

  bool empty() const { return log_odds.empty(); }
  /// Probability in [0, 1] that a cell is occupied.
  static double Probability(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }
};

}  // namespace gaitcam
