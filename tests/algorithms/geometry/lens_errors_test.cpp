#include "algorithms/geometry/lens_errors.h"

#include <gtest/gtest.h>

#include "algorithms/geometry/stereo_motion.h"
#include "tests/algorithms/geometry/stereo_rigs.h"

namespace gaitcam {
namespace {

enum { kFocal, kCentreX, kCentreY, kRightFocal };
constexpr LensUncertainty kLens = {0.003, 1, 0.0005};

StereoRig ParallelRig() {
  StereoRig rig = ChapterRig();
  rig.X_LR = Pose(Eigen::Quaterniond::Identity(), {0.1, 0, 0});
  return rig;
}

StereoRig Told(StereoRig rig, int error) {
  if (error == kRightFocal) rig.right.fx *= 1 + kLens.right_focal, rig.right.fy *= 1 + kLens.right_focal;
  for (CameraModel* camera : {&rig.left, &rig.right}) {
    if (error == kFocal) camera->fx *= 1 + kLens.focal, camera->fy *= 1 + kLens.focal;
    if (error == kCentreX) camera->cx += kLens.centre_px;
    if (error == kCentreY) camera->cy += kLens.centre_px;
  }
  return rig;
}

/// What a system sees that knows the true lens.
PointsInBoth Normalised(const TwoPairs& pairs) {
  PointsInBoth points;
  const auto sighting = [&](const StereoSighting& seen) {
    RigSighting s;
    s.left = pairs.rig.left.Unproject(seen.left).head<2>();
    s.right = pairs.rig.right.Unproject(seen.right).head<2>();
    s.covariance_left = s.covariance_right = std::pow(pairs.rig.left.fx, -2) * Eigen::Matrix2d::Identity();
    s.has_right = true;
    return s;
  };
  for (const StereoSighting& seen : pairs.A) points.A.push_back(sighting(seen));
  for (const StereoSighting& seen : pairs.B) points.B.push_back(sighting(seen));
  return points;
}

LensErrors Of(const TwoPairs& pairs) { return LensErrorsOfMotion(Normalised(pairs), pairs.rig, pairs.X_AB, kLens); }

// First order, in a part of the points, by a lens that is right: against all points, through a lens that is wrong. One
// that bends moves a shifted image by up to a fifth less at its edges than in its middle.
TEST(LensErrors, AreThoseOfMotionsMeasuredWithALensToldWrongly) {
  RandomStream random(1, "lens");
  for (const auto& [rig, tolerance] : {std::pair{ParallelRig(), 0.2}, {DistortedRig(), 0.4}}) {
    const TwoPairs pairs(rig, 400, 1, 0.2, random);
    const LensErrors predicted = Of(pairs);
    for (const int error : {kFocal, kCentreX, kCentreY}) {
      const Pose measured = RefineStereoMotion(Told(rig, error), pairs.A, pairs.B, pairs.X_AB).X_AB;
      const Vector6d found = Minus(pairs.X_AB, measured), column = predicted.col(error);
      EXPECT_LT((found - column).tail<3>().norm(), tolerance * found.tail<3>().norm()) << error;
      EXPECT_LT((found - column).head<3>().norm(), tolerance * found.head<3>().norm()) << error;
    }
  }
}

// A focal length that is told too long stretches the world along the axis; a centre that is told too far right makes
// what lies ahead seem to lie to the left.
TEST(LensErrors, OfAWayStraightAhead) {
  RandomStream random(2, "ahead");
  TwoPairs pairs(ParallelRig(), 0, 1, 0, random);
  pairs.X_AB = Pose(Eigen::Quaterniond::Identity(), {0, 0, 0.2});
  while (pairs.A.size() < 400) {
    const Eigen::Vector3d p_A = PointInView(pairs.rig, 3, 8, random), p_B = pairs.X_AB.Inverse() * p_A;
    if (!InView(pairs.rig, p_B)) continue;
    pairs.A.push_back(SeenBy(pairs.rig, p_A));
    pairs.B.push_back(SeenBy(pairs.rig, p_B));
  }
  const LensErrors errors = Of(pairs);
  const double tilt = kLens.centre_px / pairs.rig.left.fx;
  EXPECT_NEAR(errors(2, kFocal), -0.2 * kLens.focal, 0.05 * 0.2 * kLens.focal);
  EXPECT_NEAR(errors(0, kCentreX), 0.2 * tilt, 0.05 * 0.2 * tilt);
  EXPECT_NEAR(errors(1, kCentreY), 0.2 * tilt, 0.05 * 0.2 * tilt);
}

// Images that a wrong lens has moved fit no motion exactly: two pairs of frames settle that a little differently from
// one.
TEST(LensErrors, OfTwoMotionsMakeThoseOfTheWhole) {
  RandomStream random(3, "chain");
  const TwoPairs whole(ParallelRig(), 300, 1, 0.3, random);
  const Vector6d half = 0.5 * LogSe3(whole.X_AB);
  TwoPairs first = whole, second = whole;  // from A to M, and from M to B
  first.X_AB = second.X_AB = ExpSe3(half);
  for (size_t i = 0; i < whole.B.size(); ++i) {
    const Eigen::Vector3d p_B = ReconstructPoint(whole.rig, whole.B[i]).p_L;
    first.B[i] = second.A[i] = SeenBy(whole.rig, second.X_AB * p_B);
  }
  const LensErrors chained = ChainLensErrors(Of(first), second.X_AB, Of(second)), at_once = Of(whole);
  EXPECT_LT((chained - at_once).norm(), 0.2 * at_once.norm());
}

TEST(LensErrors, OfFewPointsAreNotSaid) {
  RandomStream random(4, "few");
  EXPECT_TRUE(Of(TwoPairs(ParallelRig(), 5, 1, 0.2, random)).isZero(0));
}

}  // namespace
}  // namespace gaitcam
