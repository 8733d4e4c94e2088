/// Which shapes of a picture are hidden by others, decided before anything is drawn.
///
/// Solid cores within shapes are entered into a coarse raster, with the depth behind which nothing is seen through a
/// cell. A shape is hidden if that is so for all cells that its bounding box touches. The test errs to one side only:
/// cores are smaller than what they stand for, boxes larger, and a cell counts as covered only if a single core covers
/// all of it. To leave out what is hidden therefore changes no pixel.

#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

class Cover {
 public:
  /// Of the picture of a camera without distortion. @param near_m nothing nearer along the optical axis is drawn.
  Cover(const Pose& X_WC, const CameraModel& camera, double near_m);

  /// An elliptical disc: its centre and half axes, m, world.
  struct Disc {
    Eigen::Vector3d center, a, b;
  };

  /// Enters what lies between two discs. A core that reaches the near plane hides nothing.
  void Add(const std::array<Disc, 2>& ends);
  /// Whether none of a box can be seen: all of it lies beside the picture or behind what was entered.
  /// @param low, high opposite corners in its own frame.
  bool HidesBox(const Pose& X_WB, const Eigen::Vector3d& low, const Eigen::Vector3d& high) const;

 private:
  using Corners = std::array<Eigen::Vector3d, 8>;

  /// Column and row in cells, and 1/z.
  Eigen::Vector3d Project(const Eigen::Vector3d& p_C) const;
  void AddSide(const std::array<Disc, 2>& ends);
  void AddDisc(const Disc& disc);
  void AddPolygon(std::span<const Eigen::Vector3d> polygon);
  bool Hides(const Corners& corners) const;

  Pose X_CW_;
  double near_;
  double fx_, fy_, cx_, cy_;  ///< In cells, of which the first spans 0 to 1.
  int columns_, rows_;
  std::vector<float> nearness_;  ///< 1/z beyond which a cell shows nothing, 1/m; 0: it may show anything.
};

}  // namespace gaitcam
