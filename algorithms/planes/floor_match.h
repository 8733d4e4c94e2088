/// How well a keyframe's picture of the floor agrees with earlier ones, and where it agrees best.
///
/// Likelihood (instead of the thesis's Eq. 6.22, a plain sum of differences). Each of n floor points that earlier
/// pictures know has a residual r = seen - (gain known + offset), gain and offset fitted; a residual is Gaussian noise
/// of sensor, cell and blur with standard deviation `noise_grey`, or, at a part of the points, anything at all:
/// log p = -1/2 sum rho(r / noise_grey), rho(e) = c^2 log(1 + e^2/c^2), c = 3. Neighbouring points err together: the
/// sum counts for `independent` of the points.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/planar_pose.h"
#include "algorithms/planes/floor_patch.h"

namespace gaitcam {

struct FloorMatchOptions {
  using DescribedTag = void;

  int min_points = 80;  ///< Fewer in known floor say nothing.
  double noise_grey = 8.0;
  double independent = 0.05;     ///< Part of the points that the likelihood counts.
  double least_sigma_m = 0.003;  ///< Of a match: pictures are rectified only so well.
  double least_sigma_deg = 0.2;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorMatchOptions& o) {
  visit("min_points", o.min_points, Between(4, 100000), "fewer in known floor say nothing");
  visit("noise_grey", o.noise_grey, Between(0.1, 255.0), "standard deviation of a floor point's residual");
  visit("independent", o.independent, Between(1e-4, 1.0), "part of the points that the likelihood counts");
  visit("least_sigma_m", o.least_sigma_m, Between(1e-5, 1.0), "least standard deviation of a match");
  visit("least_sigma_deg", o.least_sigma_deg, Between(1e-3, 90.0), "least standard deviation of a match");
}

/// An earlier picture and where it lies.
struct KnownFloor {
  const FloorPatch* patch;
  PlanarPose pose;
  int step = 0;  ///< Of which keyframe.
};

/// A picture compared with earlier ones from one place.
struct FloorAgreement {
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;

  Matrix5 H = Matrix5::Zero();  ///< Gauss-Newton's, of (x, y, yaw in the pose's frame, gain, offset).
  Vector5 g = Vector5::Zero();  ///< Downhill.
  double mean_rho = 0;          ///< -2 log p per point.
  double correlation = 0;
  int points = 0;  ///< That some earlier picture knows.
};

/// @param level of the pictures that are compared.
FloorAgreement AgreementOf(const std::vector<KnownFloor>& known, const FloorPatch& patch, int level,
                           const PlanarPose& pose, double gain, double offset, double noise_grey);

/// Where the pictures agree best.
struct FloorMatch {
  Eigen::Vector3d moved;       ///< x, y (m), yaw (rad) from the expected pose, in its frame ...
  Eigen::Matrix3d covariance;  ///< ... as are these.
  int points = 0;
  double mean_rho = 0, correlation = 0;
};

/// A worse mean over the points is no match: as if all were off by 1.5 standard deviations.
double WorstMeanRho();

/// Gauss-Newton from the expected pose, coarse pictures first; it draws from about 3 cm. Nothing if too few points are
/// known.
std::optional<FloorMatch> MatchFloor(const std::vector<KnownFloor>& known, const FloorPatch& patch,
                                     const PlanarPose& expected, const FloorMatchOptions& options);

}  // namespace gaitcam
