/// Social forces between people who walk, and from what stands about.
///
/// M. Moussaid, D. Helbing, S. Garnier, A. Johansson, M. Combe and G. Theraulaz, "Experimental study of the behavioural
/// mechanisms underlying self-organization in human crowds", Proc. R. Soc. B 276 (2009): a model whose parameters were
/// measured on people who pass each other in a corridor. Its equations are in section 3c there.

#pragma once

#include <Eigen/Core>

namespace gaitcam {

/// Somebody as others see him.
struct Passer {
  Eigen::Vector2d position{0, 0}, velocity{0, 0};  ///< m, m/s.
};

/// Acceleration towards a wanted velocity, m/s^2: with the time constant of 0.54 s.
Eigen::Vector2d DrivingForce(const Eigen::Vector2d& wanted, const Eigen::Vector2d& velocity);

/// Acceleration of `self` in avoiding `other`, m/s^2. @param nearer_m taken off their distance, for somebody broader
/// than a person.
Eigen::Vector2d AvoidingForce(const Passer& self, const Passer& other, double nearer_m = 0);

/// Acceleration of who is about to touch somebody, m/s^2. @param away unit vector from the other one. After D. Helbing,
/// I. Farkas and T. Vicsek, "Simulating dynamical features of escape panic", Nature 407 (2000): what keeps people apart
/// where those who pass each other in an empty corridor never come.
Eigen::Vector2d TouchForce(double distance_m, const Eigen::Vector2d& away);

/// Acceleration away from a wall or piece of furniture, m/s^2. @param gap_m between it and the body. @param away unit
/// vector.
Eigen::Vector2d WallForce(double gap_m, const Eigen::Vector2d& away);

}  // namespace gaitcam
