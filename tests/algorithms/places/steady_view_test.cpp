#include "algorithms/places/steady_view.h"

#include <gtest/gtest.h>

#include <vector>

namespace gaitcam {
namespace {

/// A frame whose grey value is its number; one IMU sample in the middle of its exposure.
Observation Frame(int number, double rate_rad_s, bool double_support) {
  Observation observation;
  observation.stamp_ns = 100'000'000LL * number;
  observation.exposure_ms = 10;
  observation.image = {observation.stamp_ns, cv::Mat(2, 2, CV_8UC1, cv::Scalar(number))};
  observation.imu.push_back({observation.stamp_ns, Eigen::Vector3d(0, rate_rad_s, 0), Eigen::Vector3d::Zero()});
  JointSample sample;
  sample.left_contact = true;
  sample.right_contact = double_support;
  observation.joints = {sample};
  return observation;
}

/// The frame that is picked of frames 1 to 4.
int Picked(Steadiness steadiness, const std::vector<double>& rates, const std::vector<bool>& double_support) {
  SteadyViewPicker picker(steadiness, 0.29);
  for (int k = 0; k < 4; ++k) {
    const auto view =
        picker.Add(Frame(k + 1, rates[size_t(k)], double_support[size_t(k)]), -Eigen::Vector3d::UnitY(), 0.1 * k);
    EXPECT_EQ(view.has_value(), k == 3);
    if (!view) continue;
    const int number = view->image.at<uchar>(0, 0);
    EXPECT_EQ(view->stamp_ns, 100'000'000LL * number);
    EXPECT_EQ(view->heading_rad, 0.1 * (number - 1));
    return number;
  }
  return 0;
}

TEST(SteadyView, IsTheFrameThatTurnsLeastOrStandsOnBothFeet) {
  EXPECT_EQ(Picked(Steadiness::kGyro, {0.4, 0.1, 0.3, 0.2}, {true, false, false, false}), 2);
  EXPECT_EQ(Picked(Steadiness::kDoubleSupport, {0.4, 0.1, 0.3, 0.2}, {true, false, false, false}), 1);
  EXPECT_EQ(Picked(Steadiness::kLast, {0.4, 0.1, 0.3, 0.2}, {true, false, false, false}), 4);
}

TEST(SteadyView, OfEqualsIsTheLaterOne) {
  EXPECT_EQ(Picked(Steadiness::kGyro, {0.3, 0.1, 0.1, 0.2}, {true, true, true, true}), 3);
}

TEST(SteadyView, AfterAResetTheIntervalBeginsAnew) {
  SteadyViewPicker picker(Steadiness::kGyro, 0.29);
  for (int k = 1; k <= 3; ++k) EXPECT_FALSE(picker.Add(Frame(k, 0.01, true), -Eigen::Vector3d::UnitY(), 0));
  picker.Reset();
  for (int k = 4; k <= 6; ++k) EXPECT_FALSE(picker.Add(Frame(k, 0.1 * k, true), -Eigen::Vector3d::UnitY(), 0));
  const auto view = picker.Add(Frame(7, 1, true), -Eigen::Vector3d::UnitY(), 0);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->stamp_ns, 400'000'000);
}

}  // namespace
}  // namespace gaitcam
