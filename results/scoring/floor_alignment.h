/// Registration of a mapped floor with the true one: the small rigid motion that maximises their correlation.
///
/// Coarse to fine, without gradients: exhaustive search of the permitted range at the coarsest smoothing, then hill
/// climbing with decreasing steps and smoothing, from the best offset found and from the initial one.

#pragma once

#include <Eigen/Core>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/floor_picture.h"
#include "results/scoring/alignment.h"

namespace gaitcam {

/// Rotation and translation on the floor: p_W = Rot(yaw) p_V + translation.
struct FloorMotion {
  double yaw = 0;  ///< rad
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();

  FloorMotion() = default;
  FloorMotion(double yaw, const Eigen::Vector2d& translation) : yaw(yaw), translation(translation) {}
  /// What a rotation and translation in space do to the floor; tilt, height and scale are dropped.
  explicit FloorMotion(const Similarity& X);

  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const;
  FloorMotion Inverse() const;
};
FloorMotion operator*(const FloorMotion& X_AB, const FloorMotion& X_BC);

/// The true floor from straight above, in the world W of the truth.
struct FloorTruth {
  cv::Mat grey;                                        ///< CV_8UC1; row 0 towards +y, column 0 towards -x.
  double px_per_m = 0;                                 ///< One pixel per cell of the map, better two.
  Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  ///< x, y of the centre of the pixel in row 0, column 0.

  /// Its extent, outer edges of the pixels.
  Eigen::Vector2d Min() const;
  Eigen::Vector2d Max() const;
};

/// The mean of the true floor over the area of a cell, wherever the cell lies and however it is turned.
class TrueFloor {
 public:
  static constexpr float kBeyond = std::numeric_limits<float>::quiet_NaN();

  /// @throws BadOption for a picture that is empty or of another type.
  TrueFloor(const FloorTruth& truth, double cell_m);

  /// 0..255 at the cell with middle `p_W` and a side along `yaw`; kBeyond for a middle that is not on the floor.
  float Mean(const Eigen::Vector2d& p_W, double yaw) const;
  /// The same without averaging, of the floor smoothed by a Gaussian of `sigma_m`: for many looks at one smoothness.
  TrueFloor Smoothed(double sigma_m) const;
  float Point(const Eigen::Vector2d& p_W) const;

  double cell_m() const { return cell_m_; }

 private:
  cv::Mat grey_;  ///< CV_32FC1
  double px_per_m_, cell_m_;
  Eigen::Vector2d corner_m_;
};

/// Correlation of two series, in [-1, 1]; NaN if one of them does not vary or both are shorter than 2.
class Correlation {
 public:
  void Add(double a, double b);
  double Value() const;
  /// Least squares: a gain + offset is nearest to b.
  double Gain() const;
  double Offset() const;
  int64_t count() const { return n_; }

 private:
  int64_t n_ = 0;
  double a_ = 0, b_ = 0, aa_ = 0, bb_ = 0, ab_ = 0;
};

struct FloorAlignmentOptions {
  using DescribedTag = void;
  double max_shift_m = 0.15;
  double max_turn_deg = 3;
  double smoothing_m = 0.02;
  double first_step_m = 0.03;
  double last_step_m = 0.0003;
  int max_cells = 20000;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorAlignmentOptions& o) {
  visit("max_shift_m", o.max_shift_m, Between(0, 10), "largest shift along x and y each");
  visit("max_turn_deg", o.max_turn_deg, Between(0, 180), "largest turn about the middle of what was mapped");
  visit("smoothing_m", o.smoothing_m, Between(0, 1),
        "standard deviation of the first smoothing; halved down to the cell");
  visit("first_step_m", o.first_step_m, Between(1e-4, 1), "step of the search over the whole range");
  visit("last_step_m", o.last_step_m, Between(1e-6, 1), "steps are halved down to this");
  visit("max_cells", o.max_cells, Between(10, 1e9), "so many of the map's cells are looked at, evenly spread");
}

/// @param map with only those cells marked as seen that count. @param X_WV where the search begins.
/// @returns the motion of highest correlation; X_WV itself if none is better.
FloorMotion AlignFloor(const FloorPicture& map, const TrueFloor& truth, const FloorMotion& X_WV,
                       const FloorAlignmentOptions& options = {});

/// The middle of a map's pixel, in V. Both may lie between pixels.
Eigen::Vector2d CellMiddle(const FloorPicture& map, double column, double row);

}  // namespace gaitcam
