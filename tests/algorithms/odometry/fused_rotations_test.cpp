#include "algorithms/odometry/fused_rotations.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  std::vector<FrameEstimate> images, seen_from, live;
  std::vector<Eigen::Quaterniond> truth;
  FusedRotations fused;
  int64_t frames = 0, sampled_ns = 0;

  explicit Shown(bool has_poses = true) : fused(Gyroscope()) {
    for (int k = 1; k <= 30; ++k) {
      const Observation frame = NextFrame();
      truth.push_back(HeadAt(1e-9 * double(frame.stamp_ns)));
      FrameEstimate answer;
      answer.stamp_ns = frame.stamp_ns;
      const double instant_s = 1e-3 * kExposure_ms * (0.618 * k - std::floor(0.618 * k) - 0.5);
      if (has_poses) answer.pose = Pose(HeadAt(1e-9 * double(frame.stamp_ns) + instant_s), {0.1 * k, 0, 0});
      images.push_back(answer);
      fused.Add(answer.pose ? RotationChain::Rotation(answer.pose->rotation) : std::nullopt, false);
      if (answer.pose) {
        seen_from.push_back(answer);
        seen_from.back().pose->rotation = fused.SeenFrom();
        answer.pose->rotation = *fused.Present();
      }
      live.push_back(answer);
    }
  }

  Observation NextFrame() {
    Observation frame;
    frame.stamp_ns = ++frames * kFrame_ns;
    frame.exposure_ms = kExposure_ms;
    for (; sampled_ns < frame.stamp_ns + 40'000'000; sampled_ns += kSample_ns) {
      const double t_s = 1e-9 * double(sampled_ns), half_s = 0.5e-9 * double(kSample_ns);
      const Eigen::Vector3d turn = LogSo3(HeadAt(t_s - half_s).conjugate() * HeadAt(t_s + half_s));
      frame.imu.push_back({sampled_ns, turn / (2 * half_s), {0, 9.81, 0}});
    }
    fused.Begin(frame);
    return frame;
  }

  /// Root mean square over the frames from the tenth on, rad.
  double Error(const std::vector<FrameEstimate>& of) const {
    double sum = 0;
    for (size_t k = 10; k < of.size(); ++k) sum += LogSo3(truth[k].conjugate() * of[k].pose->rotation).squaredNorm();
    return std::sqrt(sum / double(of.size() - 10));
  }
};

TEST(FusedRotations, AnImageOfAnotherInstantOfItsExposureTurnsThemLittle) {
  const Shown shown;
  std::vector<FrameEstimate> final = shown.seen_from;
  shown.fused.Smooth(final);
  const double images = shown.Error(shown.images);
  EXPECT_GT(images, 0.02);
  EXPECT_LT(shown.Error(shown.live), 0.3 * images);
  EXPECT_LT(shown.Error(final), 0.3 * images);
}

TEST(FusedRotations, AnImageIsSeenFromTheInstantThatItShows) {
  const Shown shown;
  double worst = 0;
  for (size_t k = 10; k < 30; ++k)
    worst = std::max(worst, RotationAngle(shown.seen_from[k].pose->rotation, shown.images[k].pose->rotation));
  EXPECT_LT(worst, 0.5 * shown.Error(shown.images)) << "that is a root mean square";
}

/// What an image says wrongly, and no instant of its exposure.
TEST(FusedRotations, NoImageIsSeenFromWhereTheCameraNeverWas) {
  Shown shown;
  shown.NextFrame();
  shown.fused.Add(RotationChain::Rotation(HeadAt(3.1) * ExpSo3({0, 0, 0.1})), false);
  EXPECT_LT(std::abs(LogSo3(HeadAt(3.1).conjugate() * shown.fused.SeenFrom()).z()), 0.02);
}

TEST(FusedRotations, PredictTheNextFrame) {
  Shown shown;
  shown.NextFrame();
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
