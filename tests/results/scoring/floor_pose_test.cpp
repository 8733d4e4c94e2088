#include "results/scoring/floor_pose.h"

#include <gtest/gtest.h>

#include "results/scoring/metrics.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

TEST(FloorPose, ATiltAndAHeightAreFoundAsTheyAre) {
  const Trajectory truth = SwayingCircle(50, 1, 2);
  Trajectory estimate = truth;
  for (StampedPose& p : estimate) {
    p.pose = Pose(Eigen::Matrix3d(RotX(0.02) * RotZ(0.7)), {3, 4, 0}) * p.pose;  // a yaw and a shift are no error
    p.pose.translation.z() = 0;
  }
  for (size_t i = 0; i < truth.size(); ++i) estimate[i].pose.translation.z() = truth[i].pose.translation.z() + 0.01;
  const FloorPoseMeasures measures = MeasureFloorPoses(PairUp(truth, estimate));
  for (const double deg : measures.normal_deg) EXPECT_NEAR(deg, 0.02 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(Summarize(measures.height_m).mean, 0.01, 1e-12);
}

}  // namespace
}  // namespace gaitcam
