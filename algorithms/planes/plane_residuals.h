/// Photometric residuals of a plane's alignment and their derivatives (thesis 6.4.1, Eq. 6.19), motion blur included.
///
/// A blurred picture of each image is compared: the reference smeared by the current exposure's path, the current image
/// by the reference's. Each then carries both blurs, whichever of them was sharp.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/planes/image_pyramid.h"
#include "algorithms/planes/plane_reference.h"
#include "algorithms/planes/plane_warp.h"

namespace gaitcam {

/// What is known of the current image's blur before its pose is.
struct CurrentBlur {
  double ratio = 0;                     ///< Exposure over the time since the previous frame; 0: sharp.
  Pose X_RP;                            ///< Pose of the previous frame in R.
  std::optional<Eigen::Vector3d> turn;  ///< Rotation vector of the camera in its own frame during the exposure, by a
                                        ///< gyroscope; without it, the velocity since P is extrapolated.

  CurrentBlur(double ratio = 0) : ratio(ratio) {}  // NOLINT: a ratio alone is the common case
  BlurMotion Motion(const Pose& X_CR) const;
};

/// Residual of one reference pixel.
struct PlaneResidual {
  double value = 0;                 ///< current - (gain reference + offset), grey levels.
  double reference = 0;             ///< Intensity of the reference there.
  Eigen::Matrix<double, 1, 9> row;  ///< Derivative of `value` by tau of X_CR Exp(tau) and by the log inverse depths.
};

/// The residuals of one pyramid level.
class PlaneResiduals {
 public:
  /// @param k level of both pyramids. All arguments must outlive this.
  PlaneResiduals(const CameraModel& camera, int max_blur_samples, const PlaneReference& reference,
                 const ImagePyramid& current, size_t k, const CurrentBlur& blur);

  const Eigen::Matrix3d& M() const { return M_; }
  const Eigen::Matrix3d& M_inverse() const { return M_inverse_; }
  size_t points() const { return points_.size(); }
  /// Of the pixels that both images show under that state.
  std::vector<PlaneResidual> At(const PlaneState& state) const;
  /// Root mean square over the points of their displacement by a step of tau and log inverse depths, px of this level.
  double Displacement_px(const PlaneState& state, const Eigen::Matrix<double, 9, 1>& step) const;

 private:
  /// What does not depend on the point.
  struct Shared {
    Eigen::Matrix3d R, H, Mz;  ///< Mz: derivative of n_d by the logarithms of the inverse depths.
    Eigen::Vector3d t, n_d;
    double gain, offset;
    BlurMotion blur;
    bool blurred;
  };
  Shared SharedOf(const PlaneState& state) const;
  std::optional<PlaneResidual> ResidualAt(const Shared& s, const Eigen::Vector2d& p_R,
                                          const Eigen::Vector3d& ray) const;
  Eigen::Matrix<double, 2, 3> PixelJacobian(const Eigen::Vector3d& p) const;
  std::optional<ImageSample> Average(const PyramidLevel& level, const Eigen::Vector2d& p,
                                     const Eigen::Vector2d& path) const;
  /// Displacement in the image during an exposure, px, of the point p (camera frame, m).
  Eigen::Vector2d Path(const Eigen::Vector3d& p, const BlurMotion& motion) const;

  const CameraModel& camera_;
  int max_blur_samples_;
  const PyramidLevel& reference_;
  const PyramidLevel& current_;
  const std::vector<Eigen::Vector2d>& points_;
  const BlurMotion& reference_blur_;
  const CurrentBlur& blur_;
  double scale_, fx_, fy_;             ///< Focal lengths in pixels of this level.
  std::vector<Eigen::Vector3d> rays_;  ///< Of the points.
  /// Of k samples along a path, from offsets_[k (k - 1) / 2] on: where each lies, in parts of the path from its middle.
  std::vector<double> offsets_;
  Eigen::Matrix3d M_, M_inverse_;
};

}  // namespace gaitcam
