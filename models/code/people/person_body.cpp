#include "models/code/people/person_body.h"

#include <algorithm>
#include <cmath>

#include "models/code/people/person_steps.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Frame of a bone that leads from `top` (its origin) down to `bottom`, with x as near to `forward` as can be.
Pose BoneFrame(const Vector3d& top, const Vector3d& bottom, const Vector3d& forward) {
  Eigen::Matrix3d R;
  R.col(2) = (top - bottom).normalized();
  R.col(0) = (forward - forward.dot(R.col(2)) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {R, top};
}

/// The joint between two links of given lengths, on the side of `forward`.
Vector3d MiddleJoint(const Vector3d& from, const Vector3d& to, double first, double second, const Vector3d& forward) {
  const double distance = (to - from).norm();
  const Vector3d along = (to - from) / distance;
  const double a = (first * first - second * second + distance * distance) / (2 * distance);
  const double h = std::sqrt(std::max(0.0, first * first - a * a));
  return from + a * along + h * (forward - forward.dot(along) * along).normalized();
}

/// How far an arm is raised in talking, 0 to 1. Periods that share no multiple keep it from repeating.
double Gesture(const PersonManner& manner, double time_s, int side) {
  const double t = time_s + manner.phase_s + 1.7 * side;
  const double slow = 0.5 + 0.5 * std::sin(2 * M_PI * t / 4.3), quick = 0.75 + 0.25 * std::sin(2 * M_PI * t / 1.1);
  return manner.talks * slow * quick * (0.5 + 0.5 * std::sin(2 * M_PI * t / 9.7));
}

void PoseLeg(const PersonBody& body, const PersonStance& stance, int side, PersonPose& pose) {
  const auto at = [&](PersonPart part) -> Pose& { return pose[size_t(part) + size_t(side)]; };
  const PersonFoot& foot = stance.feet[size_t(side)];
  at(PersonPart::kLeftShoe) = foot.Shoe();
  at(PersonPart::kLeftToes) = foot.Toes();
  const Vector3d hip = stance.hips * Vector3d(0, (side == 0 ? 1 : -1) * body.hip_half_width, 0);
  const Vector3d ankle = foot.Shoe() * Vector3d(-body.ankle_back, 0, body.ankle_height);
  const double leg_yaw = (stance.hips_yaw + foot.yaw) / 2;
  const Vector3d ahead(std::cos(leg_yaw), std::sin(leg_yaw), 0);
  const Vector3d knee = MiddleJoint(hip, ankle, body.thigh, body.shank, ahead);
  at(PersonPart::kLeftThigh) = BoneFrame(hip, knee, ahead);
  at(PersonPart::kLeftShank) = BoneFrame(knee, ankle, ahead);
}

/// Swings with the opposite leg; raised in a gesture; @param rests how far forward it lies of who sits, rad.
void PoseArm(const PersonBody& body, const PersonStance& stance, int side, double rests, double gesture,
             PersonPose& pose) {
  const double left = side == 0 ? 1 : -1;
  const double swing = 0.75 * left * stance.right_ahead / body.height * kUsualHeight_m + rests + 0.35 * gesture;
  const Pose& chest = pose[size_t(PersonPart::kChest)];
  const Pose X_WS(Eigen::Matrix3d(chest.R() * RotX(left * 0.1) * RotY(-swing)),
                  chest * Vector3d(0, left * body.shoulder_half_width, body.shoulder - body.waist));
  pose[size_t(PersonPart::kLeftUpperArm) + size_t(side)] = X_WS;
  const double bent = 0.25 + 0.5 * std::max(0.0, swing) + rests + 1.1 * gesture;
  pose[size_t(PersonPart::kLeftForearm) + size_t(side)] =
      Pose(Eigen::Matrix3d(X_WS.R() * RotY(-bent)), X_WS * Vector3d(0, 0, -body.upper_arm));
}

}  // namespace

const std::string& PersonPartName(PersonPart part) {
  static const std::array<std::string, kPersonParts> names = {
      "hips",         "chest",         "head",       "left_upper_arm", "right_upper_arm",
      "left_forearm", "right_forearm", "left_thigh", "right_thigh",    "left_shank",
      "right_shank",  "left_shoe",     "right_shoe", "left_toes",      "right_toes"};
  return names[size_t(part)];
}

PersonBody::PersonBody(double height_m)
    : height(height_m),
      thigh(0.24 * height_m),
      shank(0.24 * height_m),
      hip_half_width(0.05 * height_m),
      waist(0.1 * height_m),
      neck(0.33 * height_m),
      shoulder(0.285 * height_m),
      shoulder_half_width(0.118 * height_m),
      upper_arm(0.175 * height_m),
      forearm(0.15 * height_m),
      ankle_height(0.052 * height_m),
      ankle_back(0.08 * height_m),
      heel(0.112 * height_m),
      toes(0.052 * height_m),
      foot_aside(0.045 * height_m),
      foot_ahead(0.065 * height_m) {}

double Ease(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

PersonPose PoseParts(const PersonBody& body, const PersonStance& stance, const PersonManner& manner, double time_s) {
  constexpr double kStill = 0.4;  // m/s: who walks faster neither talks nor looks about
  const double still = 1 - Ease(stance.speed / kStill), t = time_s + manner.phase_s;
  const double look = still * manner.looks * (0.7 * std::sin(2 * M_PI * t / 7.9) + 0.3 * std::sin(2 * M_PI * t / 3.1));
  const double rests = manner.seat_m > 0 ? 0.55 : 0;
  PersonPose pose;
  const auto at = [&pose](PersonPart part) -> Pose& { return pose[size_t(part)]; };
  at(PersonPart::kHips) = stance.hips;
  at(PersonPart::kChest) = Pose(Eigen::Matrix3d(RotZ(2 * stance.yaw - stance.hips_yaw) * RotY(0.035 * stance.speed)),
                                stance.hips * Vector3d(0, 0, body.waist));
  at(PersonPart::kHead) =
      Pose(RotZ(stance.yaw + look), at(PersonPart::kChest) * Vector3d(0, 0, body.neck - body.waist));
  for (int side = 0; side < 2; ++side) {
    PoseLeg(body, stance, side, pose);
    PoseArm(body, stance, side, rests, still * Gesture(manner, time_s, side), pose);
  }
  return pose;
}

}  // namespace gaitcam
