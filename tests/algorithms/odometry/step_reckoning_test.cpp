#include "algorithms/odometry/step_reckoning.h"

#include <gtest/gtest.h>

#include <numbers>

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

TEST(StepReckoning, AStepIsAChangeOfTheLegThatItStandsOn) {
  StepReckoning steps;
  steps.Add(Feet("BLLBBRRBLB"), 0);
  EXPECT_EQ(steps.steps(), 2);
  EXPECT_EQ(steps.position(), Eigen::Vector2d(2, 0));
}

TEST(StepReckoning, AFootThatChattersMakesNoStep) {
  StepReckoning steps;
  steps.Add(Feet("LBLBL-LBRBRBR-BR"), 0);
  EXPECT_EQ(steps.steps(), 1);
}

TEST(StepReckoning, StandingMakesNoStep) {
  StepReckoning steps;
  steps.Add(Feet("BBBBBBBB"), 0);
  steps.Add({}, 0);
  EXPECT_EQ(steps.steps(), 0);
}

TEST(StepReckoning, TheWayFollowsTheHeading) {
  StepReckoning steps;
  steps.Add(Feet("LRLRL"), 0);                   // 4 forward
  steps.Add(Feet("RLR"), std::numbers::pi / 2);  // 3 to the left
  steps.Add(Feet("LRLR"), std::numbers::pi);     // 4 back
  EXPECT_EQ(steps.steps(), 11);
  EXPECT_NEAR((steps.position() - Eigen::Vector2d(0, 3)).norm(), 0, 1e-12);
  steps.SetPosition({5, 5});
  steps.Add(Feet("L"), 0);
  EXPECT_NEAR((steps.position() - Eigen::Vector2d(6, 5)).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace gaitcam
