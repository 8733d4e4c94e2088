/// Zero-moment-point preview control: how the centre of mass must move so that the ZMP follows a plan known in advance.
///
/// Kajita et al., "Biped Walking Pattern Generation by using Preview Control of Zero-Moment Point", ICRA 2003. The
/// walker is a cart of height z_c on a massless table; its state is (position, velocity, acceleration) and its input
/// the jerk:
///   x(k+1) = A x(k) + b u(k),   p(k) = c x(k),   c = (1, 0, -z_c / g)                                  (eq. 9)
/// The input that minimises  sum Q_e e(k)^2 + R du(k)^2,  e = p - p_ref, is
///   u(k) = -G_i sum e(i) - G_x x(k) - sum_{j=1..N} G_d(j) p_ref(k+j)                                   (eq. 12)
/// Ours: beyond the horizon the reference is taken to stay as it is at its end, where eq. 12 takes it to be 0: so that
/// walks do not depend on where the world has its origin. A tall robot, 0.5 m, fell 8 m from it.
/// Lateral and forward motion are independent: one controller holds both.

#pragma once

#include <Eigen/Core>
#include <vector>

namespace gaitcam {

constexpr double kGravity = 9.81;  ///< m/s^2

struct PreviewOptions {
  double period_s = 0.004;       ///< Time between two updates.
  double com_height_m = 0.157;   ///< z_c
  double horizon_s = 1.0;        ///< How far ahead the plan is looked at.
  double tracking_weight = 1.0;  ///< Q_e
  double jerk_weight = 1e-6;     ///< R
};

/// The cart in the plane: each column is an axis (x, y), the rows are position m, velocity m/s, acceleration m/s^2.
using CartState = Eigen::Matrix<double, 3, 2>;

class PreviewControl {
 public:
  /// Solves the Riccati equation for the gains. @throws BadOption for a height, period or horizon that is not positive.
  explicit PreviewControl(const PreviewOptions& options);

  /// Number of reference values that Update() needs: the present one and those ahead.
  int reference_count() const { return int(preview_gains_.size()) + 1; }

  /// Rests the cart at `position`.
  void Reset(const Eigen::Vector2d& position);
  /// Advances by one period. `zmp_reference[j]` is the planned ZMP j periods from now; at least reference_count() of
  /// them.
  void Update(const std::vector<Eigen::Vector2d>& zmp_reference);

  Eigen::Vector2d position() const { return state_.row(0); }
  Eigen::Vector2d velocity() const { return state_.row(1); }
  Eigen::Vector2d acceleration() const { return state_.row(2); }
  /// Of the cart-table model, c x.
  Eigen::Vector2d Zmp() const { return output_ * state_; }
  /// The divergent component of motion, x + v / omega, which a ZMP pushes away from itself.
  Eigen::Vector2d Dcm() const { return position() + velocity() / natural_frequency(); }
  /// omega = sqrt(g / z_c), 1/s.
  double natural_frequency() const;

  double integral_gain() const { return integral_gain_; }                      ///< G_i
  const std::vector<double>& preview_gains() const { return preview_gains_; }  ///< G_d(1..N)

 private:
  double com_height_m_;
  Eigen::Matrix3d transition_;
  Eigen::Vector3d input_;
  Eigen::RowVector3d output_;
  double integral_gain_ = 0;
  Eigen::RowVector3d state_gain_;
  std::vector<double> preview_gains_;
  CartState state_ = CartState::Zero();
  Eigen::RowVector2d error_sum_ = Eigen::RowVector2d::Zero();
};

}  // namespace gaitcam
