/// Bundle adjustment: poses of cameras and places of points, together, from where the points are seen (Triggs
/// et al. 2000; solved by Ceres).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

struct BundleCamera {
  Pose X_WC;  ///< Start value; refined unless fixed.
  bool fixed = false;
};

/// A point on the ray through `ray` of camera `anchor`; see inverse_depth.h.
struct BundlePoint {
  int anchor = 0;
  Eigen::Vector2d xy;      ///< Where the anchor saw it.
  double sigma = 0;        ///< Standard deviation of each coordinate, > 0.
  Eigen::Vector2d ray;     ///< Start value, `xy` to begin with; refined.
  double rho = 0;          ///< Start value; refined.
  double prior_rho = 0;    ///< What is thought of its inverse depth before it is seen twice ...
  double prior_sigma = 0;  ///< ... and how little that is worth, > 0.
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
  std::vector<BundleObservation> observations;  ///< Without those of the anchors, which stand in the points.
};

struct BundleOptions {
  int max_iterations = 8;
  double huber = 2.0;  ///< Residuals beyond so many standard deviations count linearly.
};

struct BundleResult {
  double cost_before = 0, cost_after = 0;  ///< Half the sum of robust squared residuals, priors included.
};

/// Refines the problem in place. Deterministic. Where no camera is fixed, or only one, position or scale are held by
/// the priors and the damping alone.
BundleResult AdjustBundle(BundleProblem& problem, const BundleOptions& options);

}  // namespace gaitcam
