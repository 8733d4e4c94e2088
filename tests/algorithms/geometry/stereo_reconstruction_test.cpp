#include "algorithms/geometry/stereo_reconstruction.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "algorithms/core/random.h"
#include "tests/algorithms/geometry/stereo_rigs.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using Eigen::Vector3d;

const StereoCost kCosts[] = {StereoCost::kAlgebraic, StereoCost::kMaximumLikelihood};

TEST(StereoReconstruction, ExactPixelsGiveThePointThroughDistortionAndRotation) {
  RandomStream random(1, "exact");
  for (const StereoRig& rig : {ChapterRig(), DistortedRig()}) {
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3d p = PointInView(rig, 0.8, 20, random);
      for (const StereoCost cost : kCosts) {
        const StereoPoint point = ReconstructPoint(rig, Seen(rig, p), {cost, 0});
        ASSERT_TRUE(point.ok());
        EXPECT_LT((point.p_L - p).norm(), 1e-9 * p.squaredNorm());  // 1e-12 px of undistortion grow as depth squared
        EXPECT_LT(point.squared_error, 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace gaitcam
