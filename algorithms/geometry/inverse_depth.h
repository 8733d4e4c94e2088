/// Points in inverse-depth form: a ray of the camera that observed them first and the inverse depth along it (Civera,
/// Davison and Montiel, TRO 2008). A point of unknown depth, or at infinity, constrains rotation as well as any other,
/// and its error is nearly Gaussian in this form.
///
/// A point anchored in camera A lies at (x, y, 1) / rho in A's frame. Seen from camera C its direction is
///   h = R_C^T (R_A (x, y, 1)^T + rho (t_A - t_C)),                                                              (1)
/// which holds for rho = 0 too. All coordinates are normalised (undistorted, focal length 1).

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"

namespace gaitcam {

/// A landmark.
struct InverseDepthPoint {
  Pose X_WA;                                     ///< The anchor: the camera that observed it first ...
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< ... and its image there.
  double xy_sigma = 0;                           ///< Standard deviation of each coordinate of `xy`.
  double rho = 0;                                ///< Inverse depth, 1 over the world's unit.
  double rho_sigma = 0;                          ///< Its standard deviation.
  bool is_guess = false;                         ///< `rho` is assumed, one value for many points: one common error.
};

/// An observation of a landmark.
struct InverseDepthSighting {
  InverseDepthPoint point;
  Eigen::Vector2d xy;  ///< Measured.
  double sigma = 0;    ///< Standard deviation of each coordinate.
};

/// Equation 1 and its derivatives; those by poses in the tangent of se3.h.
struct InverseDepthProjection {
  Eigen::Vector2d xy;
  Eigen::Matrix<double, 2, 6> d_anchor;  ///< By X_WA Exp(rho, phi).
  Eigen::Matrix<double, 2, 6> d_camera;  ///< By X_WC Exp(rho, phi).
  Eigen::Matrix2d d_xy;                  ///< By the ray in the anchor.
  Eigen::Vector2d d_rho;
};

/// @returns where camera C sees the point, or nothing if it is behind.
std::optional<Eigen::Vector2d> ProjectInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                   const Pose& X_WC);

/// The same with its derivatives.
std::optional<InverseDepthProjection> LinearizeInverseDepth(const Pose& X_WA, const Eigen::Vector2d& xy, double rho,
                                                            const Pose& X_WC);

/// What equation 1 has of a point and its anchor: the same for every camera C.
struct AnchoredPoint {
  Eigen::Vector3d ray_W;     ///< R_A (x, y, 1)^T.
  Eigen::Vector3d anchor_W;  ///< t_A.
  double rho = 0;

  /// @param R_WA the anchor's rotation; @param xy the ray in the anchor.
  AnchoredPoint(const Eigen::Matrix3d& R_WA, const Eigen::Vector3d& position_W, const Eigen::Vector2d& xy,
                double inverse_depth)
      : ray_W(R_WA * Eigen::Vector3d(xy.x(), xy.y(), 1)), anchor_W(position_W), rho(inverse_depth) {}
  explicit AnchoredPoint(const InverseDepthPoint& point)
      : AnchoredPoint(point.X_WA.R(), point.X_WA.translation, point.xy, point.rho) {}
};

/// Camera C of equation 1, for many points: what does not depend on the point is computed once.
class InverseDepthCamera {
 public:
  explicit InverseDepthCamera(const Pose& X_WC) : R_CW_(X_WC.R().transpose()), position_W_(X_WC.translation) {}

  /// A point in the image.
  struct Sight {
    Eigen::Vector2d xy;
    Eigen::Vector3d h;                 ///< Equation 1.
    Eigen::Matrix<double, 2, 3> d_xy;  ///< Of xy by h.
    Eigen::Vector2d d_rho;             ///< Of xy by rho.

    /// Of xy by X_WC Exp(rho, phi).
    Eigen::Matrix<double, 2, 6> DerivativeByCamera(double rho) const;
  };
  /// @returns nothing if the point is behind.
  std::optional<Sight> See(const AnchoredPoint& point) const;
  /// Its place in the image alone.
  std::optional<Eigen::Vector2d> Project(const AnchoredPoint& point) const;

  const Eigen::Matrix3d& R_CW() const { return R_CW_; }

 private:
  Eigen::Matrix3d R_CW_;
  Eigen::Vector3d position_W_;
};

/// Squared distance between measurement and projection in standard deviations, the point's own uncertainty counted in:
/// covariance (sigma^2 + xy_sigma^2) I + d_rho rho_sigma^2 d_rho^T, the two cameras' scales being about the same.
/// Chi-square with 2 degrees of freedom for true pairs; infinity for a point behind the camera.
double Mahalanobis2(const InverseDepthSighting& sighting, const InverseDepthCamera& camera);
double Mahalanobis2(const InverseDepthSighting& sighting, const Pose& X_WC);

/// Prior of a camera's position.
struct PositionPrior {
  Eigen::Vector3d position_W = Eigen::Vector3d::Zero();
  double sigma = 0;  ///< Standard deviation of each coordinate.
};

/// Maximum likelihood of the camera's pose by Gauss-Newton, Huber's weights beyond `huber` standard deviations. Points
/// of unknown depth constrain the rotation only. Guessed depths share one error, so that all of them together say as
/// much of how far the camera moved as one would.
/// @param use   indices into `sightings`
/// @param prior counts as one more measurement
/// @returns the pose, or `X_WC` itself where the problem is singular. Never NaN.
Pose RefinePose(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                double huber, const std::optional<PositionPrior>& prior = {});

/// The same with the rotation of `X_WC` held: for a rotation that is known better than these sightings tell it.
Pose RefinePosition(const std::vector<InverseDepthSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                    double huber, const std::optional<PositionPrior>& prior = {});

/// The rotation of a camera whose position is roughly known. Two sightings determine it, so that few true ones among
/// many false suffice (after the one-point RANSAC of Civera, Grasa, Davison and Montiel, JFR 2010). A hypothesis is
/// scored by the likelihood ratio of the sightings to chance; the position's uncertainty is part of it, so that near
/// points have wider tolerances and less weight.
struct TurnResult {
  Pose X_WC;                 ///< At the prior's position.
  std::vector<int> inliers;  ///< Likelier true than by chance; empty if fewer than three.
  double chance = 0;         ///< Expected number of inliers if all sightings were false.
};

/// @param field solid angle, sr, over which false sightings are uniform
TurnResult EstimateTurn(const std::vector<InverseDepthSighting>& sightings, const PositionPrior& prior,
                        const Eigen::Quaterniond& guess, double field, RandomStream& random);

}  // namespace gaitcam
