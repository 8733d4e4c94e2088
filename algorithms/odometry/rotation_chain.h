/// The rotations of successive frames from two witnesses: what each image says of its own frame, and how far a
/// gyroscope says that the camera turned from each frame to the next. The gyroscope drifts, an image does not; but an
/// image that was exposed for long shows the camera as it was at some instant of the exposure, nobody knows at which.
///
/// A Kalman filter of the error of rotation and of the gyroscope's bias gives what is known of a frame by those before
/// it, a Rauch-Tung-Striebel smoother what is known by all (S. Sarkka, "Bayesian Filtering and Smoothing", 2013,
/// sections 4.3 and 8.2). Errors of rotation are in the camera's frame: R Exp(phi).

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "algorithms/core/se3.h"

namespace gaitcam {

/// What is known of a frame's rotation without its image.
struct FrameTurn {
  std::optional<Eigen::Vector3d> turn;  ///< phi of R_BC = Exp(phi), B the camera at the frame before, rad; with bias.
  double seconds = 0;                   ///< Since that frame.
  double sigma = 0;                     ///< Standard deviation of the turn about each axis, rad, without bias.
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< Covariance of what an image says of this frame, rad^2.
};

class RotationChain {
 public:
  /// Rotations R_WC of the camera in a map; nothing where there is none.
  using Rotation = std::optional<Eigen::Quaterniond>;

  /// @param bias_sigma of each component at first, rad/s
  /// @param bias_walk what it goes from there, rad/s per square root of a second
  RotationChain(double bias_sigma, double bias_walk) : bias_sigma_(bias_sigma), bias_walk_(bias_walk) {}

  /// The next frame.
  /// @param R_WC as its image says. @param begins the map is another one than the frame's before
  /// @returns its rotation by this frame and those before; nothing where no image has told any yet. What an image says
  /// counts less the farther it lies beyond three standard deviations (Huber).
  Rotation Add(const FrameTurn& frame, const Rotation& R_WC, bool begins);

  /// Of the next frame, by those before.
  Rotation Predict(const FrameTurn& next) const;

  /// The rotations of all frames by all images.
  /// @param R_WC of each frame as its image says in the end
  std::vector<Rotation> Smoothed(const std::vector<Rotation>& R_WC) const;

 private:
  struct Link {
    FrameTurn frame;
    bool begins = false;
  };
  struct State {
    Rotation R_WC;
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();  ///< rad/s, in the camera's frame.
    Matrix6d covariance;                             ///< Of the rotation's error, then of the bias.
  };
  State First() const;
  State Turned(const State& before, const Link& link) const;
  static Matrix6d Transition(const Link& link);
  static State Updated(const State& predicted, const Link& link, const Rotation& R_WC);

  double bias_sigma_, bias_walk_;
  std::vector<Link> links_;
  std::optional<State> latest_;
};

}  // namespace gaitcam
