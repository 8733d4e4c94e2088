#include "algorithms/geometry/gyro_heading.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

const Eigen::Vector3d kUpC(0, -1, 0);
constexpr double kBiasAboutUp = 0.01;  // rad/s about the vertical

ImuCalibration HeadingImu() {
  ImuCalibration imu;
  imu.rate_hz = 100;
  return imu;
}

/// One second of turning at `rate_rad_s` about the vertical, as a gyroscope with a bias reads it.
std::vector<ImuSample> Second(double rate_rad_s) {
  std::vector<ImuSample> samples(100);
  for (ImuSample& sample : samples) {
    sample.angular_rate = (rate_rad_s + kBiasAboutUp) * kUpC;
    sample.specific_force = 9.81 * kUpC;
  }
  return samples;
}

TEST(GyroHeading, TakesBackWhatItDriftedByWhileTheRobotStood) {
  GyroHeading heading(HeadingImu(), kUpC);
  heading.Add(Second(0.5));
  EXPECT_NEAR(heading.heading_rad(), 0.5 + kBiasAboutUp, 1e-9);
  EXPECT_TRUE(heading.stale());
  for (int k = 0; k < 5; ++k) {
    heading.Add(Second(0));
    heading.Stand(Second(0));
  }
  EXPECT_NEAR(heading.heading_rad(), 0.5 + 6 * kBiasAboutUp, 1e-9);
  heading.LearnBias();
  EXPECT_TRUE(heading.bias_is_known());
  EXPECT_FALSE(heading.stale());
  EXPECT_NEAR(heading.heading_rad(), 0.5 + kBiasAboutUp, 1e-9);
  heading.Add(Second(-0.2));
  EXPECT_NEAR(heading.heading_rad(), 0.3 + kBiasAboutUp, 1e-9);
}

TEST(GyroHeading, IsSetByTheFirstObservationAndDrawnByTheNext) {
  GyroHeading heading(HeadingImu(), kUpC);
  heading.Observe(2.0 + 4 * std::acos(0.0), heading.heading_rad());  // a whole turn more is the same heading
  EXPECT_NEAR(heading.heading_rad(), 2.0, 1e-12);
  EXPECT_FALSE(heading.stale());
  heading.Observe(2.5, heading.heading_rad());
  EXPECT_NEAR(heading.heading_rad(), 2.1, 1e-12);  // a fifth of the way
}

TEST(GyroHeading, WithoutAGyroscopeChangesByCorrectionsAlone) {
  GyroHeading heading(ImuCalibration(), kUpC);
  EXPECT_FALSE(heading.has_gyroscope());
  heading.Add(Second(1));
  heading.Turn(0.25);
  heading.Stand(Second(0));
  heading.LearnBias();
  EXPECT_EQ(heading.heading_rad(), 0.25);
}

}  // namespace
}  // namespace gaitcam
