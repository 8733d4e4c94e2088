/// The body of a person: its rigid parts, their lengths, and how limbs follow from hips and feet.

#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "algorithms/core/pose.h"
#include "models/code/people/people.h"

namespace gaitcam {

/// The rigid parts of a person. Frames: x forward, y left, z up when standing; origins at the joint nearest the hips.
/// A foot has two parts, `shoe` and `toes`; both have their origin on the floor under the ball of the foot.
enum class PersonPart {
  kHips,
  kChest,
  kHead,
  kLeftUpperArm,
  kRightUpperArm,
  kLeftForearm,
  kRightForearm,
  kLeftThigh,
  kRightThigh,
  kLeftShank,
  kRightShank,
  kLeftShoe,
  kRightShoe,
  kLeftToes,
  kRightToes,
};
constexpr int kPersonParts = 15;
/// Name of the part's body in the model: "hips", "left_shoe", ...
const std::string& PersonPartName(PersonPart part);

using PersonPose = std::array<Pose, kPersonParts>;  ///< X_WP of each part.

/// Lengths of a person's parts, m. Proportions after Drillis and Contini, "Body segment parameters" (1966).
struct PersonBody {
  double height, thigh, shank, hip_half_width, waist, neck, shoulder, shoulder_half_width, upper_arm, forearm;
  double ankle_height, ankle_back;  ///< The ankle over the floor, and behind the ball of the foot.
  double heel, toes;                ///< From the ball back to the heel, and forward to the tip.
  double foot_aside, foot_ahead;    ///< Where the ball of a foot stands as seen from under the hips.
  explicit PersonBody(double height_m);
};

/// A foot on the floor or over it.
struct PersonFoot {
  Eigen::Vector3d ball{0, 0, 0};  ///< Origin of shoe and toes.
  double yaw = 0;
  double pitch = 0;  ///< Of the shoe about the ball; positive: heel up.
  double bend = 0;   ///< Of the toes against the shoe; positive: tip up.

  Pose Shoe() const { return {Eigen::Matrix3d(RotZ(yaw) * RotY(pitch)), ball}; }
  Pose Toes() const { return {Eigen::Matrix3d(RotZ(yaw) * RotY(pitch - bend)), ball}; }
};

/// What the limbs follow from.
struct PersonStance {
  std::array<PersonFoot, 2> feet;  ///< Left, right.
  Pose hips;
  double hips_yaw = 0;        ///< Of `hips`, not wrapped.
  double yaw = 0, speed = 0;  ///< Of the person, rad and m/s.
  double right_ahead = 0;     ///< By how much the right foot is ahead of the left one, m.
};

/// From 0 to 1 along the minimum-jerk curve (Flash and Hogan, 1985); constant outside.
double Ease(double x);

/// All parts: legs by inverse kinematics, arms that swing with the opposite leg, gestures and looks of who stands or
/// sits at that time.
PersonPose PoseParts(const PersonBody& body, const PersonStance& stance, const PersonManner& manner, double time_s);

}  // namespace gaitcam
