#include "algorithms/slam/step_gate.h"

#include <gtest/gtest.h>

namespace gaitcam {
namespace {

/// Straight ahead along a heading.
void Steps(StepGate& gate, int steps, double heading_rad, bool& left) {
  for (int k = 0; k < steps; ++k) {
    left = !left;
    JointSample sample;
    sample.left_contact = left;
    sample.right_contact = !left;
    gate.Walk({sample}, heading_rad);
  }
}

TEST(StepGate, APlaceIsOutOfReachOnceItLiesTooManyStepsAway) {
  StepGate gate({20, 0.1});
  bool left = false;
  gate.AddNode();
  EXPECT_TRUE(gate.InReach(0));
  Steps(gate, 21, 0, left);  // 20 steps: the first foot down is none; 20 + 0.1 x 20 are permitted
  EXPECT_TRUE(gate.InReach(0));
  Steps(gate, 5, 0, left);
  EXPECT_FALSE(gate.InReach(0));
}

TEST(StepGate, ReckoningGoesOnFromAVisitedPlace) {
  StepGate gate({20, 0.0});
  bool left = false;
  gate.AddNode();
  Steps(gate, 51, 0, left);
  gate.AddNode();
  EXPECT_FALSE(gate.InReach(0));
  EXPECT_TRUE(gate.InReach(1));
  gate.Visit(0);
  EXPECT_TRUE(gate.InReach(0));
  EXPECT_FALSE(gate.InReach(1));
}

}  // namespace
}  // namespace gaitcam
