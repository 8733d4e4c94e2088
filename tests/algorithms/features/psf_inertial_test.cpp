#include "algorithms/features/psf_inertial.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int64_t kMs = 1000000;

std::vector<ImuSample> Steady(const Eigen::Vector3d& rate, int count = 10) {
  std::vector<ImuSample> imu;
  for (int i = 0; i < count; ++i) imu.push_back({i * 4 * kMs, rate, {0, 0, 9.81}});
  return imu;
}

const CameraModel kCamera = CameraModel::FromHorizontalFov(320, 240, 60);

TEST(InertialPsf, AYawSmearsTheMiddleByFocalLengthTimesAngle) {
  const double rate = 2, exposure = 0.02;
  // The camera's y axis points down: a positive rate about it turns the view to the right, points move left.
  const InertialPsf psf(Steady({0, rate, 0}), {}, kCamera, 8 * kMs, 28 * kMs);
  const Eigen::Vector2d vector = psf.BlurVector({kCamera.cx, kCamera.cy});
  EXPECT_NEAR(vector.x(), -2 * kCamera.fx * std::tan(rate * exposure / 2), 1e-9);
  EXPECT_NEAR(vector.y(), 0, 1e-9);
}

TEST(InertialPsf, ARollTurnsPointsAboutTheOpticalAxis) {
  const double rate = 3, exposure = 0.01;
  const InertialPsf psf(Steady({0, 0, rate}), {}, kCamera, 10 * kMs, 20 * kMs);
  EXPECT_NEAR(psf.At({kCamera.cx, kCamera.cy}).extent_px, 0, 1e-9);
  const LineBlur side = psf.At({kCamera.cx + 100, kCamera.cy});
  EXPECT_NEAR(side.extent_px, 2 * 100 * std::sin(rate * exposure / 2), 1e-9);
  EXPECT_NEAR(side.direction_rad, M_PI / 2, 1e-9);
}

TEST(InertialPsf, TheImusFrameIsTurnedIntoTheCameras) {
  ImuCalibration calibration;
  // IMU x forward, y left, z up; camera x right, y down, z forward.
  Eigen::Matrix3d R_CI;
  R_CI << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.X_CI = Pose(R_CI, Eigen::Vector3d(0.1, 0.2, 0.3));
  const InertialPsf robot(Steady({0, 0, 1.5}), calibration, kCamera, 8 * kMs, 28 * kMs);
  const InertialPsf camera(Steady({0, -1.5, 0}), {}, kCamera, 8 * kMs, 28 * kMs);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(10, 20), Eigen::Vector2d(300, 200)}) {
    EXPECT_NEAR((robot.BlurVector(pixel) - camera.BlurVector(pixel)).norm(), 0, 1e-9);
  }
}

TEST(InertialPsf, AConstantRateGivesTheRotationOfItsAngle) {
  const auto rotations = IntegrateRotation(Steady({0.3, -2, 1}), {}, 10 * kMs, 30 * kMs, 9);
  ASSERT_EQ(rotations.size(), 9u);
  EXPECT_EQ(rotations.front().stamp_ns, 10 * kMs);
  EXPECT_EQ(rotations.back().stamp_ns, 30 * kMs);
  EXPECT_NEAR(rotations[4].rotation.angularDistance(Eigen::Quaterniond::Identity()), 0, 1e-9);  // middle
  const double angle = Eigen::Vector3d(0.3, -2, 1).norm() * 0.02;
  EXPECT_NEAR(rotations.back().rotation.angularDistance(rotations.front().rotation), angle, 1e-9);
}

TEST(InertialPsf, AReadingCountsForTheTimeAroundItsStamp) {
  // 1 rad/s at 0 and 3 rad/s at 10 ms: from 0 to 10 ms half of each.
  const std::vector<ImuSample> imu = {{0, {0, 0, 1}, {}}, {10 * kMs, {0, 0, 3}, {}}};
  const auto rotations = IntegrateRotation(imu, {}, 0, 10 * kMs);
  EXPECT_NEAR(rotations.back().rotation.angularDistance(rotations.front().rotation), 0.02, 1e-9);
}

TEST(InertialPsf, ThereAndBackIsNoBlurToTrust) {
  std::vector<ImuSample> imu = Steady({0, 2, 0});
  for (size_t i = 5; i < imu.size(); ++i) imu[i].angular_rate = -imu[i].angular_rate;
  // Stamps 16 and 20 ms turn one way and the other; the rate changes its sign at 18 ms.
  const InertialPsf psf(imu, {}, kCamera, 8 * kMs, 28 * kMs);
  const BlurEstimate e = psf.EstimateWhole(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)));
  EXPECT_LT(e.confidence, 0.05);
  EXPECT_FALSE(e.blurred);
}

TEST(InertialPsf, AKnownBiasIsTakenAway) {
  const Eigen::Vector3d bias(0.1, -0.2, 0.3);
  const InertialPsf psf(Steady(bias), {}, kCamera, 8 * kMs, 28 * kMs, bias);
  EXPECT_NEAR(psf.At({5, 5}).extent_px, 0, 1e-9);
}

TEST(InertialPsf, RegionsHaveThePathsOfTheirMiddles) {
  // Faster and faster, and about the optical axis: neither a line nor one for the whole image.
  std::vector<ImuSample> imu = Steady({0, 0, 3});
  for (size_t i = 0; i < imu.size(); ++i) imu[i].angular_rate *= double(i) / double(imu.size());
  const InertialPsf psf(imu, {}, kCamera, 8 * kMs, 28 * kMs);
  const std::vector<BlurRegion> regions = psf.Regions();
  EXPECT_GT(regions.size(), 4u);
  int pixels = 0, blurred = 0;
  for (const BlurRegion& region : regions) {
    pixels += region.rectangle.area();
    blurred += region.estimate.blurred;
    const Eigen::Vector2d middle(region.rectangle.x + 0.5 * (region.rectangle.width - 1),
                                 region.rectangle.y + 0.5 * (region.rectangle.height - 1));
    const std::vector<Eigen::Vector2d> path = psf.Path(middle);
    ASSERT_EQ(path.size(), region.path.points.size());
    for (size_t i = 0; i < path.size(); ++i) EXPECT_LT((path[i] - middle - region.path.points[i]).norm(), 1e-9);
    EXPECT_LT(region.path.points[path.size() / 2].norm(), 1e-6);  // in its place at mid-exposure
    EXPECT_EQ(region.estimate.blurred, region.path.Length() >= 3);
  }
  EXPECT_EQ(pixels, kCamera.width_px * kCamera.height_px);
  EXPECT_GT(blurred, 0);
}

TEST(InertialPsf, WithoutReadingsThereIsNoBlur) {
  EXPECT_THROW(IntegrateRotation({}, {}, 0, kMs), BadInput);
  EXPECT_THROW(IntegrateRotation(Steady({0, 0, 1}), {}, kMs, 0), BadInput);
}

}  // namespace
}  // namespace gaitcam
