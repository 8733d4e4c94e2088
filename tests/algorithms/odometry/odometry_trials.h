/// Films that odometries are tried on, what may befall them, and what must hold of every answer.

#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/algorithms/odometry/synthetic_scene.h"

namespace gaitcam {

// Small, so that the tests are fast: 208 px focal length.
inline const CameraModel kCamera = CameraModel::FromHorizontalFov(240, 180, 60);

inline Calibration OneCamera() {
  Calibration calibration;
  calibration.camera = kCamera;
  calibration.frame_rate_hz = 30;
  return calibration;
}

inline const SyntheticScene& Room() {
  static const SyntheticScene room(1);
  return room;
}

// Sideways at 25 cm/s, looking at a wall 3 m away and the floor before it: parallax within half a second.
inline Pose SidewaysPose(double t_s) { return LookingForward({-0.5, -0.8 + 0.25 * t_s, 0.5}, 0, -0.3, 0); }

inline const Film& SidewaysFilm() {
  static const Film film = FilmPath(Room(), kCamera, 40, SidewaysPose, 5, 2);
  return film;
}

constexpr double kRollsFor_ms = 20, kRollingGyro_hz = 200;

inline Calibration Rolling(Calibration calibration) {
  calibration.readout_ms = kRollsFor_ms;
  calibration.imu.rate_hz = kRollingGyro_hz;
  return calibration;
}

/// Sideways, while the head turns to and fro and nods: by 0.05 rad, three times a second.
inline Pose NoddingPose(double t_s) {
  const double phase = 2 * M_PI * 3 * t_s;
  const Pose steady = SidewaysPose(t_s);
  return {RotZ(0.05 * std::sin(phase)) * steady.rotation * RotX(0.05 * std::cos(phase)), steady.translation};
}

/// What a rolling shutter makes of it, every row an instant, and what a gyroscope in the camera measures meanwhile:
/// with a frame come the samples up to 5 ms after its stamp; its last row is read 10 ms after it.
/// @param X_NC of the camera in the head that nods
inline Film RollingFilm(const CameraModel& camera, int frames, const Pose& X_NC = {}) {
  Film film;
  RandomStream random(8, "rolling");
  for (int k = 0; k < frames; ++k) {
    const double t_s = k / 30.0;
    const auto pose_of_row = [&](int row) {
      return NoddingPose(t_s + 1e-3 * kRollsFor_ms * (double(row) / (camera.height_px - 1) - 0.5)) * X_NC;
    };
    cv::Mat grey = Room().RenderRows(camera, pose_of_row, {0, 0});
    for (float& value : cv::Mat_<float>(grey)) value += float(random.Normal(0, 1.5));
    Observation observation;
    observation.stamp_ns = observation.image.stamp_ns = 1'000'000'000 + std::llround(1e9 * t_s);
    grey.convertTo(observation.image.pixels, CV_8UC1);
    const double until_s = t_s + 0.25e-3 * kRollsFor_ms;
    for (int i = int(std::ceil((until_s - 1 / 30.0) * kRollingGyro_hz)); i < until_s * kRollingGyro_hz; ++i) {
      ImuSample sample;
      sample.stamp_ns = 1'000'000'000 + std::llround(1e9 * i / kRollingGyro_hz);
      const Pose before = NoddingPose((i - 0.5) / kRollingGyro_hz), after = NoddingPose((i + 0.5) / kRollingGyro_hz);
      sample.angular_rate = LogSo3(before.rotation.conjugate() * after.rotation) * kRollingGyro_hz;
      observation.imu.push_back(sample);
    }
    film.frames.push_back(observation);
    film.truth.push_back({observation.stamp_ns, NoddingPose(t_s) * X_NC});
  }
  return film;
}

inline Observation Filled(const Observation& like, int grey) {
  Observation filled = like;
  filled.image.pixels = cv::Mat(like.image.pixels.size(), CV_8UC1, cv::Scalar(grey));
  return filled;
}

template <class Odometry>
Estimate TrackAll(Odometry& vo, const std::vector<Observation>& frames) {
  Estimate estimate;
  for (const Observation& frame : frames) estimate.frames.push_back(vo.Track(frame));
  return estimate;
}

// Root mean square distance of the estimated positions from the true ones after the best similarity.
struct Sim3Error {
  double rmse_m = 0, scale = 0;
};
inline Sim3Error AlignedError(const Estimate& estimate, const Trajectory& truth) {
  const Trajectory path = estimate.ToTrajectory();
  Eigen::Matrix3Xd from(3, path.size()), to(3, path.size());
  for (size_t i = 0; i < path.size(); ++i) {
    from.col(long(i)) = path[i].pose.translation;
    to.col(long(i)) = PoseAt(truth, path[i].stamp_ns)->translation;
  }
  const Eigen::Matrix4d S = Eigen::umeyama(from, to, true);
  const Eigen::Matrix3Xd moved = (S * from.colwise().homogeneous()).topRows<3>();
  return {std::sqrt((moved - to).colwise().squaredNorm().mean()), S.block<3, 1>(0, 0).norm()};
}

inline int Count(const Estimate& estimate, TrackingStatus status) {
  int count = 0;
  for (const FrameEstimate& frame : estimate.frames) count += frame.status == status;
  return count;
}

// No NaN, a pose exactly when tracking, a prediction only without one, and no jump that is not marked: 25 cm/s are 8 mm
// per frame, in units of 2 to 4 m.
inline void ExpectSane(const Estimate& estimate) {
  std::optional<Pose> last;
  for (size_t i = 0; i < estimate.frames.size(); ++i) {
    const FrameEstimate& frame = estimate.frames[i];
    ASSERT_EQ(frame.pose.has_value(), frame.status == TrackingStatus::kTracking) << i;
    ASSERT_FALSE(frame.pose && frame.predicted) << i;
    ASSERT_TRUE(!frame.predicted || frame.predicted->Matrix().allFinite()) << i;
    if (!frame.pose) continue;
    ASSERT_TRUE(frame.pose->Matrix().allFinite()) << i;
    if (last && !frame.restarted) {
      EXPECT_LT((frame.pose->translation - last->translation).norm(), 0.15) << i;
    }
    last = frame.pose;
  }
}

inline void ExpectSameBits(const Estimate& a, const Estimate& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].status, b.frames[i].status) << "frame " << i;
    EXPECT_EQ(a.frames[i].features, b.frames[i].features);
    EXPECT_EQ(a.frames[i].inliers, b.frames[i].inliers);
    ASSERT_EQ(a.frames[i].pose.has_value(), b.frames[i].pose.has_value());
    if (!a.frames[i].pose) continue;
    EXPECT_EQ(a.frames[i].pose->translation, b.frames[i].pose->translation);
    EXPECT_EQ(a.frames[i].pose->rotation.coeffs(), b.frames[i].pose->rotation.coeffs());
  }
}

// What happens to frames 27 to 31 of the film, and whether a pose may be had in them all the same.
struct Mishap {
  std::string name;
  std::function<Observation(const Observation&)> befalls;
};

inline void PrintTo(const Mishap& mishap, std::ostream* out) { *out << mishap.name; }

inline std::vector<Mishap> Mishaps() {
  return {Mishap{"Black", [](const Observation& o) { return Filled(o, 0); }},
          Mishap{"Saturated", [](const Observation& o) { return Filled(o, 255); }},
          Mishap{"Frozen",
                 [](const Observation& o) {
                   Observation frozen = o;
                   frozen.image.pixels = SidewaysFilm().frames[26].image.pixels;
                   return frozen;
                 }},
          Mishap{"Dark",
                 [](const Observation& o) {
                   Observation dark = o;
                   dark.image.pixels = cv::Mat(o.image.pixels * 0.25);
                   return dark;
                 }},
          Mishap{"Overexposed", [](const Observation& o) {
                   Observation bright = o;
                   bright.image.pixels = cv::Mat(o.image.pixels * 2);  // a new picture: the film is shared
                   return bright;
                 }}};
}

}  // namespace gaitcam
