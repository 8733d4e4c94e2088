/// The unit of a monocular map in metres, by how high a camera is carried over the floor.
///
/// A landmark at p, seen by the keyframe at t first, with inverse depth rho there, lies on a floor of unit normal n
/// that is H below a point c, if
///   rho = -m . r,   m = n / H,   r = rho (p - c) = rho (p - t) + rho (t - c).                                      (1)
/// So the floor is a linear function of the rays, whose three coefficients are fitted to many landmarks of several
/// keyframes at once; c is where the camera was on average over some steps, which bobbing does not move. Gravity says
/// roughly where n points: a floor seen under flat angles tells height and tilt badly apart. What a landmark's prior
/// says of its depth (FloorPrior) is taken out of it before: otherwise the map would confirm what it was told.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/odometry/keyframe_map.h"

namespace gaitcam {

/// Of a camera on average over some steps.
struct Carried {
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();  ///< A unit vector, to a degree or so.
  Eigen::Vector3d at_W = Eigen::Vector3d::Zero();   ///< Mean position.
};

/// A first-order low-pass filter with a time constant of two seconds, some steps: accelerations and bobbing cancel out,
/// drift of the poses' rotation is followed. Until two seconds have passed it is the plain mean.
class CarriedMean {
 public:
  /// To be called for every frame that has a pose, stamps strictly increasing. The filter's gain is the time since the
  /// frame before over two seconds, or 1 / n at the n-th frame if that is more.
  /// @param up_W vertical as this frame has it, a unit vector. @param at_W its position, in the map's unit.
  void Add(int64_t stamp_ns, const Eigen::Vector3d& up_W, const Eigen::Vector3d& at_W);
  /// The next frame is the first.
  void Restart() { frames_ = 0; }

  const Carried& mean() const { return mean_; }

 private:
  Carried mean_;
  int frames_ = 0;  ///< That count in the mean, at the latest frame's rate.
  int64_t stamp_ns_ = 0;
};

/// How high the camera was carried lately.
struct CarriedHeight {
  double height = 0;                                    ///< Of Carried::at_W over the floor, in the map's unit.
  double relative_sigma = 0;                            ///< Standard deviation of its logarithm.
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  ///< Of the floor, up; a unit vector.
  std::vector<Eigen::Vector3d> seen_on_floor_W;  ///< Landmarks that it was measured by and the latest keyframe sees.
};

/// The lowest plane that is about level and that many landmarks of the latest keyframes lie on.
/// @returns nothing if there are too few landmarks, or many below every such plane.
std::optional<CarriedHeight> MeasureCarriedHeight(const KeyframeMap& map, const Carried& carried);

/// Metres per unit of a map over its keyframes: a random walk of the logarithm, measured at keyframes.
class MetricScale {
 public:
  /// @param height_m at which the camera is carried, m.
  explicit MetricScale(double height_m) : height_m_(height_m) {}

  /// To be called once for every keyframe, in order.
  /// @param new_map its unit says nothing of the last map's.
  void Add(const std::optional<CarriedHeight>& measured, bool new_map);

  /// As far as is known at the latest keyframe; nothing until it is known to a few per cent.
  std::optional<double> latest() const;

  /// At every keyframe, by all measurements of its map; of maps without any, the nearest earlier one's, and 1 if there
  /// is none.
  std::vector<double> Smoothed() const;

 private:
  /// Gaussians of the logarithm; the variance is infinite where nothing is known.
  struct Belief {
    double mean = 0, variance = 0;
  };
  struct Keyframe {
    bool begins_map = false;
    Belief filtered;
  };

  double height_m_;
  std::vector<Keyframe> keyframes_;
};

}  // namespace gaitcam
