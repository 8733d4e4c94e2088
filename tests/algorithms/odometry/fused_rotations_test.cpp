#include "algorithms/odometry/fused_rotations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "algorithms/core/se3.h"

namespace gaitcam {
namespace {

constexpr int64_t kFrame_ns = 100'000'000, kSample_ns = 4'000'000;
constexpr double kExposure_ms = 60;

/// A head that nods and swings by up to 2 rad/s.
Eigen::Quaterniond HeadAt(double t_s) { return ExpSo3({0.1 * std::sin(20 * t_s), 0.15 * std::sin(13 * t_s), 0}); }

ImuCalibration Gyroscope() {
  ImuCalibration imu;
  imu.rate_hz = 250;
  imu.gyro_noise_density = 2e-4;
  return imu;
}

/// The frames of three seconds; the image of each shows the head as it was at another instant of the exposure.
struct Shown {
  std::vector<FrameEstimate> images, live;
  std::vector<Eigen::Quaterniond> truth;
  FusedRotations fused;

  explicit Shown(bool has_poses = true) : fused(Gyroscope()) {
    int64_t sampled_ns = 0;
    for (int k = 1; k <= 30; ++k) {
      Observation frame;
      frame.stamp_ns = k * kFrame_ns;
      frame.exposure_ms = kExposure_ms;
      for (; sampled_ns < frame.stamp_ns + 40'000'000; sampled_ns += kSample_ns) {
        const double t_s = 1e-9 * double(sampled_ns), half_s = 0.5e-9 * double(kSample_ns);
        const Eigen::Vector3d turn = LogSo3(HeadAt(t_s - half_s).conjugate() * HeadAt(t_s + half_s));
        frame.imu.push_back({sampled_ns, turn / (2 * half_s), {0, 9.81, 0}});
      }
      fused.Begin(frame);
      truth.push_back(HeadAt(1e-9 * double(frame.stamp_ns)));
      FrameEstimate answer;
      answer.stamp_ns = frame.stamp_ns;
      const double instant_s = 1e-3 * kExposure_ms * (0.618 * k - std::floor(0.618 * k) - 0.5);
      if (has_poses) answer.pose = Pose(HeadAt(1e-9 * double(frame.stamp_ns) + instant_s), {0.1 * k, 0, 0});
      images.push_back(answer);
      fused.Fuse(answer);
      live.push_back(answer);
    }
  }

  /// Root mean square over the frames from the tenth on, rad.
  double Error(const std::vector<FrameEstimate>& frames) const {
    double sum = 0;
    for (size_t k = 10; k < frames.size(); ++k)
      sum += LogSo3(truth[k].conjugate() * frames[k].pose->rotation).squaredNorm();
    return std::sqrt(sum / double(frames.size() - 10));
  }
};

TEST(FusedRotations, AnImageOfAnotherInstantOfItsExposureTurnsThemLittle) {
  const Shown shown;
  std::vector<FrameEstimate> final = shown.images;
  shown.fused.Smooth(final);
  const double images = shown.Error(shown.images);
  EXPECT_GT(images, 0.02);
  EXPECT_LT(shown.Error(shown.live), 0.3 * images);
  EXPECT_LT(shown.Error(final), 0.3 * images);
}

TEST(FusedRotations, PositionsStay) {
  const Shown shown;
  std::vector<FrameEstimate> final = shown.images;
  shown.fused.Smooth(final);
  for (size_t k = 0; k < final.size(); ++k) {
    EXPECT_EQ(shown.live[k].pose->translation, shown.images[k].pose->translation) << k;
    EXPECT_EQ(final[k].pose->translation, shown.images[k].pose->translation) << k;
  }
}

TEST(FusedRotations, PredictTheNextFrame) {
  Shown shown;
  Observation next;
  next.stamp_ns = 31 * kFrame_ns;
  for (int64_t at_ns = 30 * kFrame_ns + 40'000'000; at_ns <= 31 * kFrame_ns; at_ns += kSample_ns) {
    const double t_s = 1e-9 * double(at_ns);
    next.imu.push_back({at_ns, LogSo3(HeadAt(t_s - 0.002).conjugate() * HeadAt(t_s + 0.002)) / 0.004, {0, 9.81, 0}});
  }
  shown.fused.Begin(next);
  ASSERT_TRUE(shown.fused.Predicted());
  EXPECT_LT(LogSo3(HeadAt(3.1).conjugate() * *shown.fused.Predicted()).norm(), 0.02);
}

TEST(FusedRotations, WithoutAnyPoseThereIsNothingToPredictBy) {
  const Shown shown(false);
  EXPECT_FALSE(shown.fused.Predicted());
  for (const FrameEstimate& frame : shown.live) EXPECT_FALSE(frame.pose);
}

}  // namespace
}  // namespace gaitcam
