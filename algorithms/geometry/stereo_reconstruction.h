/// Points from a calibrated pair of cameras that stand anyhow to each other, and what the points are worth.
///
/// Source: Valencia, section 2.1 and 2.3.1. The left camera's frame is the reference. Nothing is rectified: lens
/// distortion is undone for each pixel, and "ideal pixels" below are those of the same camera without it.
///
/// Eq. 2.2 uses [R t] to map points of the left frame into the right camera, while the text calls (R, t) the pose of
/// the right camera's frame in the reference frame. Both cannot be: with the chapter's t = (0.385, 0.007, 0) m, Eq. 2.2
/// by the letter puts the right camera to the left of the left one. Here the pose is X_LR, as the text says, and
/// [R t] of Eqs. 2.2 and 2.3 is its inverse X_RL.

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// Two cameras fixed to each other.
struct StereoRig {
  CameraModel left, right;
  Pose X_LR;  ///< Maps points of the right camera into the left one.

  /// @throws BadInput if there is no right camera, and as Check().
  static StereoRig Of(const Calibration& calibration);

  /// @throws BadInput in one line: no baseline, a rotation that is none, cameras that see nothing in common (beyond a
  /// tenth of the image) at any depth. A camera without size or focal length: BadOption.
  void Check() const;
  /// The share of the left image whose points at `depth_m` (of the left camera) the right camera sees too.
  double Overlap(double depth_m) const;
};

/// A point's two images, and how well they are known.
struct StereoSighting {
  Eigen::Vector2d left, right;                                     ///< Pixels, distorted as filmed.
  Eigen::Matrix2d covariance_left = Eigen::Matrix2d::Identity();   ///< px^2, positive definite.
  Eigen::Matrix2d covariance_right = Eigen::Matrix2d::Identity();  ///< px^2. Errors left and right are independent.
};

enum class StereoCost {
  kAlgebraic,          ///< Valencia, Eq. 2.25: of ideal pixels times depth, covariances without a say.
  kMaximumLikelihood,  ///< Reprojection errors over their covariances. Beyond the chapter.
};
constexpr auto WordsOf(StereoCost) {
  return std::array{EnumWord{StereoCost::kAlgebraic, "algebraic"},
                    EnumWord{StereoCost::kMaximumLikelihood, "maximum_likelihood"}};
}

struct ReconstructionOptions {
  StereoCost cost = StereoCost::kMaximumLikelihood;
  double min_depth_sigmas = 3;  ///< A depth of fewer of its own standard deviations is too far; 0: none is.
};

enum class StereoStatus {
  kOk,
  kNoRay,     ///< A pixel is not finite, or no ray reaches it through this lens.
  kParallel,  ///< The rays do not converge: a point at infinity.
  kBehind,    ///< The rays meet behind a camera.
  kTooFar,    ///< Infinity is not excluded: see ReconstructionOptions::min_depth_sigmas.
};
constexpr auto WordsOf(StereoStatus) {
  return std::array{EnumWord{StereoStatus::kOk, "ok"}, EnumWord{StereoStatus::kNoRay, "no_ray"},
                    EnumWord{StereoStatus::kParallel, "parallel"}, EnumWord{StereoStatus::kBehind, "behind"},
                    EnumWord{StereoStatus::kTooFar, "too_far"}};
}

/// A reconstructed point. Unless the status is kOk, nothing else is set: the point is NaN.
struct StereoPoint {
  StereoStatus status = StereoStatus::kNoRay;
  Eigen::Vector3d p_L;                ///< m, in the left camera's frame.
  Eigen::Matrix<double, 3, 4> J;      ///< d p_L / d (u, v, u', v'), m/px (Eq. 2.27).
  Eigen::Matrix3d covariance;         ///< m^2, of first order (Eq. 2.24).
  Eigen::Vector3d bias;               ///< m: by how much p_L is too far on average, of second order.
  Eigen::Matrix3d covariance_second;  ///< m^2, what the terms of second order add to the covariance.
  double squared_error = 0;  ///< Reprojection error over its covariance: chi-square of 1 degree for a right match.
  /// What the terms of second order add to the NEES, its root: some 2.2 times the depth's relative error.
  double nonlinearity = 0;
  /// The covariance of first order says what it should, to a tenth in NEES.
  bool first_order_holds = false;

  bool ok() const { return status == StereoStatus::kOk; }
};

/// The point that two images show. Errors of pixels are taken as Gaussian, the lens as linear over them.
///
/// Of StereoCost::kAlgebraic, one property that is easily missed: inverting a noisy disparity puts points too far on
/// average, by (sigma_z / z)^2 z; noise of vertical disparities makes this cost shrink points. Where pixels err alike
/// in both directions the two cancel; the likelihood has the first alone.
StereoPoint ReconstructPoint(const StereoRig& rig, const StereoSighting& sighting,
                             const ReconstructionOptions& options = {});

/// Eq. 2.26 alone: wherever the point lies, behind the cameras too. NaN where a pixel has no ray. For Monte Carlo.
Eigen::Vector3d SolveLinearly(const StereoRig& rig, const Eigen::Vector2d& left, const Eigen::Vector2d& right);

/// Whether images were given as they were filmed or with left for right, told by where matches lie.
enum class ImageOrder { kRight, kSwapped, kUnknown };

/// Rays of swapped images diverge: their disparities are negative. Told by the majority of the matches, of which some
/// may be wrong; kUnknown for fewer than 10 matches or no clear majority (of three quarters).
ImageOrder TellImageOrder(const StereoRig& rig, const std::vector<StereoSighting>& matches);

}  // namespace gaitcam
