/// Pictures of a mapped floor and of the true one, upright in W. An inner part of floor_score.cpp.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "algorithms/core/floor_picture.h"
#include "results/scoring/floor_alignment.h"

namespace gaitcam::internal {

/// The ground that pictures show: where the map and the true floor meet, with a margin; row 0 towards +y.
class FloorSheet {
 public:
  /// @param map its cells with sightings count. @pre not empty
  FloorSheet(const FloorPicture& map, const FloorTruth& floor, const FloorMotion& X_WV, double margin_m);

  bool empty() const { return size_.empty(); }
  cv::Size size() const { return size_; }
  double cell_m() const { return cell_m_; }
  /// x, y in W of the centre of the pixel in row 0, column 0.
  Eigen::Vector2d corner_m() const { return corner_m_; }
  /// x, y in W of a pixel, which may lie between pixels.
  Eigen::Vector2d Middle(double u, double v) const { return corner_m_ + cell_m_ * Eigen::Vector2d(u, -v); }

  struct DrawnMap {
    cv::Mat grey;       ///< CV_32FC1, 0 where not seen.
    cv::Mat seen;       ///< CV_8UC1
    cv::Mat sightings;  ///< CV_16UC1
  };
  /// The map between its cells: bilinear over those that were seen at least `min_sightings` times.
  DrawnMap Draw(const FloorPicture& map, const FloorMotion& X_WV, int min_sightings) const;

  /// CV_32FC1; TrueFloor::kBeyond where there is no floor.
  cv::Mat DrawTruth(const TrueFloor& floor) const;

 private:
  double cell_m_;
  cv::Size size_;
  Eigen::Vector2d corner_m_ = Eigen::Vector2d::Zero();
};

/// CV_8UC1: logarithm of the number of sightings, 255 at the maximum.
cv::Mat MaskPicture(const cv::Mat& sightings);

/// CV_8UC3: gain and offset of `fit` applied to the map, minus the truth. White equal, red too bright, blue too dark,
/// saturated at `full_scale_grey`; dark grey outside `both`.
cv::Mat DifferencePicture(const cv::Mat& map, const cv::Mat& truth, const cv::Mat& both, const Correlation& fit,
                          double full_scale_grey);

}  // namespace gaitcam::internal
