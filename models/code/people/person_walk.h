/// Kinematics of a walking person: footsteps along a path, and the limbs by inverse kinematics.
///
/// A pure function of time. Stance feet do not slip: a foot lands on its heel, rolls until it is flat, and rolls over
/// its ball before it lifts; throughout, heel or ball is at rest. The hips follow the feet, as high as the legs reach;
/// the knees follow from two links of constant length.

#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "models/code/people/people.h"
#include "models/code/people/person_body.h"
#include "models/code/people/person_steps.h"

namespace gaitcam {

class PersonWalk {
 public:
  /// Part of a step during which its foot is in the air; then both feet are on the floor.
  static constexpr double kSwing = 0.75;
  /// How far ahead steps are planned, s. A pose depends on the hips at the two double supports to come, of which the
  /// second one belongs to a step that begins within an eighth of a step and a whole one, each 0.6 s long at most.
  static constexpr double kPlanned_s = 0.7;

  /// @pre the options were checked, as ReadOption does.
  explicit PersonWalk(const PersonOptions& options);

  /// Any time, also negative.
  PersonPose At(double time_s) const;

  /// Follows another course from `time_s` on. Until then all poses stay as they were, to rounding; so do the steps that
  /// begin within kPlanned_s, as nobody changes a step that is on its way.
  /// @pre the walk follows a course that begins at the same time and pose.
  void FollowFrom(double time_s, std::shared_ptr<const PersonCourse> course);

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
  /// Where the hips are at an instant: x, y, yaw (not wrapped), and how fast that changes.
  struct HipsKnot {
    double time_s;
    Eigen::Vector3d pose, rate;
    bool still;
  };

  double LapTime(double time_s) const;
  void PlanSteps();
  void FollowCourse(std::vector<PersonStep> begun);
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
  PersonFoot FootAt(int side, double lap_s) const;
  PersonFoot Standing(int side, const FootSpot& print, double pitch) const;
  PersonFoot Swinging(const PersonStep& step, double part) const;
  double PushOff(const PersonStep& step) const;
  double Landing(const PersonStep& step) const;
  PersonStance Upright(double lap_s) const;
  PersonStance Sitting() const;
  double HipsHeight(const std::array<PersonFoot, 2>& feet, const Eigen::Vector3d& hips) const;

  PersonOptions options_;
  PersonBody body_;
  double step_length_ = 0, duration_s_ = 0;
  std::vector<PersonStep> steps_;
  std::array<FootSpot, 2> first_, last_;  ///< Prints before the first planned step, and after the last.
  std::vector<HipsKnot> hips_;
};

}  // namespace gaitcam
