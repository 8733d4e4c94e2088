#include "algorithms/odometry/step_dead_reckoning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace gaitcam {
namespace {

/// Foot switches: 'L' the left foot alone, 'R' the right one, 'B' both, '-' none.
std::vector<JointSample> Feet(const std::string& states) {
  std::vector<JointSample> samples;
  for (const char state : states) {
    JointSample sample;
    sample.left_contact = state == 'L' || state == 'B';
    sample.right_contact = state == 'R' || state == 'B';
    samples.push_back(sample);
  }
  return samples;
}

TEST(StepDeadReckoning, AStepIsAChangeOfTheSupportingLeg) {
  StepDeadReckoning steps;
  steps.Add(Feet("BLLBBRRBLB"), 0);
  EXPECT_EQ(steps.steps(), 2);
  EXPECT_EQ(steps.position(), Eigen::Vector2d(2, 0));
}

TEST(StepDeadReckoning, AFootThatChattersMakesNoStep) {
  StepDeadReckoning steps;
  steps.Add(Feet("LBLBL-LBRBRBR-BR"), 0);
  EXPECT_EQ(steps.steps(), 1);
}

TEST(StepDeadReckoning, StandingMakesNoStep) {
  StepDeadReckoning steps;
  steps.Add(Feet("BBBBBBBB"), 0);
  steps.Add({}, 0);
  EXPECT_EQ(steps.steps(), 0);
}

/// `count` steps, one at a time, the heading the same.
void Walk(StepDeadReckoning& steps, int count, double heading_rad) {
  for (int k = 0; k < count; ++k) steps.Add(Feet(steps.steps() % 2 == 0 ? "LBR" : "RBL"), heading_rad);
}

TEST(StepDeadReckoning, ThePositionFollowsTheHeading) {
  StepDeadReckoning steps(1e9);  // however it turns
  Walk(steps, 4, 0);
  Walk(steps, 3, std::numbers::pi / 2);
  Walk(steps, 4, std::numbers::pi);
  EXPECT_EQ(steps.steps(), 11);
  EXPECT_NEAR((steps.position() - Eigen::Vector2d(0, 3)).norm(), 0, 1e-6);
  steps.SetPosition({5, 5});
  Walk(steps, 1, 0);
  EXPECT_NEAR((steps.position() - Eigen::Vector2d(6, 5)).norm(), 0, 1e-6);
}

TEST(StepDeadReckoning, AStepThatTurnsIsShorter) {
  StepDeadReckoning straight(0.15), curve(0.15), spot(0.15);
  Walk(straight, 40, 0);
  EXPECT_NEAR(straight.position().x(), 40, 1e-12);
  // 0.075 rad a step: half of each step's length, after four steps by which the turn is felt in full.
  double length = 0;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector2d before = curve.position();
    Walk(curve, 1, 0.075 * k);
    if (k >= 4) {
      EXPECT_NEAR((curve.position() - before).norm(), 0.5, 1e-9);
    }
    length += (curve.position() - before).norm();
  }
  EXPECT_LT(length, 24);
  for (int k = 0; k < 40; ++k) Walk(spot, 1, 0.2 * k);
  EXPECT_LT(spot.position().norm(), 4.1);  // those first four
}

TEST(StepDeadReckoning, ATrunkThatSwaysWalksStraight) {
  StepDeadReckoning steps;
  for (int k = 0; k < 40; ++k) Walk(steps, 1, k % 2 == 0 ? 0.05 : -0.05);
  EXPECT_NEAR(steps.position().x(), 40, 0.1);  // cos(0.05) of each
  EXPECT_NEAR(steps.position().y(), 0, 0.1);
}

}  // namespace
}  // namespace gaitcam
