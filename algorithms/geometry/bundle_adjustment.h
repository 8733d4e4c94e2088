/// Bundle adjustment: camera poses and point positions together, from the points' images (B. Triggs, P. McLauchlan,
/// R. Hartley and A. Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

struct BundleCamera {
  Pose X_WC;  ///< Initial value; refined unless fixed.
  bool fixed = false;
};

/// A point on the ray through `ray` of camera `anchor`; see inverse_depth.h.
struct BundlePoint {
  int anchor = 0;
  Eigen::Vector2d xy;      ///< Its image in the anchor, normalised coordinates.
  double sigma = 0;        ///< Standard deviation of each coordinate, > 0.
  Eigen::Vector2d ray;     ///< Initial value; refined.
  double rho = 0;          ///< Initial value; refined.
  double prior_rho = 0;    ///< Prior of its inverse depth ...
  double prior_sigma = 0;  ///< ... and its standard deviation, > 0.
  double rho_sigma = 0;    ///< Result: standard deviation, the cameras held fixed.
};

struct BundleObservation {
  int camera = 0;
  int point = 0;
  Eigen::Vector2d xy;  ///< Normalised coordinates.
  double sigma = 0;    ///< Standard deviation of each, > 0.
};

struct BundleProblem {
  std::vector<BundleCamera> cameras;
  std::vector<BundlePoint> points;
  std::vector<BundleObservation> observations;  ///< Without those of the anchors (BundlePoint::xy).
};

struct BundleOptions {
  int max_iterations = 8;
  double huber = 2.0;  ///< Threshold of Huber's loss, in standard deviations.
};

struct BundleResult {
  double cost_before = 0, cost_after = 0;  ///< Half the sum of robust squared residuals, priors included.
};

/// Refines the problem in place. Deterministic. With fewer than two fixed cameras, pose or scale are
/// determined by the priors and the damping alone.
BundleResult AdjustBundle(BundleProblem& problem, const BundleOptions& options);

}  // namespace gaitcam
