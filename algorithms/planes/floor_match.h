/// Registration of a keyframe's floor patch with earlier ones: likelihood of a pose, and its maximum.
///
/// Likelihood (instead of the thesis's Eq. 6.22, a plain sum of differences, which FloorWeighting offers). Each of n
/// floor points that earlier patches cover has a residual r = seen - (gain known + offset), gain and offset estimated,
/// with Gaussian noise of sensor, cell and blur and with outliers: log p = -1/2 sum rho(r / noise_grey), rho(e) = c^2
/// log(1 + e^2/c^2), c = 3. Residuals of neighbouring points are correlated: the sum is weighted by `independent`.

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

  int min_points = 80;         ///< That earlier patches cover.
  double noise_grey = 8.0;     ///< Standard deviation of a residual.
  double independent = 0.05;   ///< Weight of the sum over points in the log-likelihood.
  double min_sigma_m = 0.003;  ///< Lower bound of a match's: patches are rectified no better.
  double min_sigma_deg = 0.2;
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorMatchOptions& o) {
  visit("min_points", o.min_points, Between(4, 100000), "fewer in known floor say nothing");
  visit("noise_grey", o.noise_grey, Between(0.1, 255.0), "standard deviation of a floor point's residual");
  visit("independent", o.independent, Between(1e-4, 1.0), "part of the points that the likelihood counts");
  visit("min_sigma_m", o.min_sigma_m, Between(1e-5, 1.0), "least standard deviation of a match");
  visit("min_sigma_deg", o.min_sigma_deg, Between(1e-3, 90.0), "least standard deviation of a match");
}

/// An earlier patch and its pose.
struct KnownFloor {
  const FloorPatch* patch;
  PlanarPose pose;
  int step = 0;  ///< Its keyframe's index.
};

/// A patch compared with earlier ones at one pose.
struct FloorAgreement {
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;

  Matrix5 H = Matrix5::Zero();  ///< Gauss-Newton's Hessian by (x, y, yaw in the pose's frame, gain, offset).
  Vector5 g = Vector5::Zero();  ///< Minus the gradient.
  double mean_rho = 0;          ///< -2 log p per point.
  double mean_square = 0;       ///< Of the residuals, each divided by noise_grey.
  double correlation = 0;
  int points = 0;  ///< That some earlier patch covers.
};

/// @param level of the patches.
FloorAgreement AgreementOf(const std::vector<KnownFloor>& known, const FloorPatch& patch, int level,
                           const PlanarPose& pose, double gain, double offset, double noise_grey);

/// The pose of maximum likelihood.
struct FloorMatch {
  Eigen::Vector3d moved;       ///< x, y (m), yaw (rad) from the expected pose, in its frame ...
  Eigen::Matrix3d covariance;  ///< ... as are these.
  int points = 0;
  double mean_rho = 0, correlation = 0;
};

/// Upper bound of a match's mean_rho: that of residuals of 1.5 standard deviations.
double WorstMeanRho();

/// Gauss-Newton from the expected pose, coarse to fine; converges from about 3 cm. Nothing if earlier patches cover too
/// few points.
std::optional<FloorMatch> MatchFloor(const std::vector<KnownFloor>& known, const FloorPatch& patch,
                                     const PlanarPose& expected, const FloorMatchOptions& options);

}  // namespace gaitcam
