/// Kinematics of a walking person: footsteps along a path, and the limbs by inverse kinematics.
///
/// A pure function of time. Stance feet do not slip: a foot lands on its heel, rolls until it is flat, and rolls over
/// its ball before it lifts; throughout, heel or ball is at rest. The hips follow the feet, as high as the legs reach;
/// the knees follow from two links of constant length.

#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "algorithms/core/pose.h"
#include "models/code/people/people.h"
#include "models/code/people/person_steps.h"

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

class PersonWalk {
 public:
  /// Part of a step during which its foot is in the air; then both feet are on the floor.
  static constexpr double kSwing = 0.75;

  /// @pre the options were checked, as ReadOption does.
  explicit PersonWalk(const PersonOptions& options);

  /// Any time, also negative.
  PersonPose At(double time_s) const;

  const PersonBody& body() const { return body_; }
  /// All steps of the path, or of one lap there and back if it is repeated; time 0 is when the person starts.
  const std::vector<PersonStep>& steps() const { return steps_; }
  /// Duration of the path, or of one lap.
  double duration_s() const { return duration_s_; }
  double step_length_m() const { return step_length_; }
  /// When the path, or the course of somebody in a crowd, begins.
  double start_s() const { return options_.course ? options_.course->begin_s : options_.start_s; }
  /// Whether a foot is in stance: it then moves only by rolling over heel or ball.
  bool Stands(int side, double time_s) const;

 private:
  struct Foot {
    Eigen::Vector3d ball{0, 0, 0};  ///< Origin of shoe and toes.
    double yaw = 0;
    double pitch = 0;  ///< Of the shoe about the ball; positive: heel up.
    double bend = 0;   ///< Of the toes against the shoe; positive: tip up.

    Pose Shoe() const { return {Eigen::Matrix3d(RotZ(yaw) * RotY(pitch)), ball}; }
    Pose Toes() const { return {Eigen::Matrix3d(RotZ(yaw) * RotY(pitch - bend)), ball}; }
  };
  /// Where the hips are at an instant: x, y, yaw (not wrapped), and how fast that changes.
  struct HipsKnot {
    double time_s;
    Eigen::Vector3d pose, rate;
    bool still;
  };

  double LapTime(double time_s) const;
  void PlanSteps();
  void FollowCourse();
  void AddPause(double duration_s);
  double PauseAfterStretch() const;
  void AddStep(int side, const FootSpot& to, double duration_s);
  void AddTurn(double yaw);
  void AddStretch(const std::vector<Eigen::Vector2d>& points);
  void AddHips(double time_s, bool still);
  HipsKnot HipsAt(double lap_s) const;
  std::vector<PersonStep>::const_iterator FirstStepAfter(double lap_s) const;
  const PersonStep* StepOf(int side, double lap_s) const;
  const PersonStep* NextStepOf(int side, double lap_s) const;
  Foot FootAt(int side, double lap_s) const;
  Foot Standing(int side, const FootSpot& print, double pitch) const;
  Foot Swinging(const PersonStep& step, double part) const;
  double PushOff(const PersonStep& step) const;
  double Landing(const PersonStep& step) const;
  double HipsHeight(const std::array<Foot, 2>& feet, const Eigen::Vector3d& hips) const;

  PersonOptions options_;
  PersonBody body_;
  double step_length_ = 0, duration_s_ = 0;
  std::vector<PersonStep> steps_;
  std::array<FootSpot, 2> first_, last_;  ///< Prints before the first planned step, and after the last.
  std::vector<HipsKnot> hips_;
};

}  // namespace gaitcam
