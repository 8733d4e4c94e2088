#include "sim/walking/course.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gaitcam {
namespace {

TEST(Course, FindsWhereThePlanLies) {
  const PlanarPose X_WP({0.3, -0.1}, 0.4);
  Course course;
  for (double t = 0; t < 1; t += 0.01) {
    const PlanarPose X_PB({t, 0.02 * std::sin(20 * t)}, 0.1 * std::sin(20 * t));
    course.Add(X_WP * X_PB, X_PB);
  }
  const PlanarPose found = course.Take().X_WP;
  EXPECT_NEAR((found.position - X_WP.position).norm(), 0, 1e-12);
  EXPECT_NEAR(found.heading, X_WP.heading, 1e-12);
  EXPECT_TRUE(course.empty());
}

TEST(Course, HeadingGoesOnBeyondHalfATurn) {
  Course course;
  double heading = 0, slip_rad = 0;
  for (double slip = 0; slip < 7; slip += 0.1) {
    course.Add({{0, 0}, WrapAngle(slip)}, {{0, 0}, 0});
    const PlanDrift drift = course.Take();
    heading = drift.X_WP.heading;
    EXPECT_NEAR(heading, slip, 1e-9);
    slip_rad = drift.slip_rad;
  }
  EXPECT_NEAR(slip_rad, 0.1, 0.001);  // 0.9 to the power 70 is forgotten
  EXPECT_GT(heading, 2 * std::numbers::pi);
}

}  // namespace
}  // namespace gaitcam
