#include "sim/camera/blur_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/camera/exposure.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

constexpr int64_t kStamp = 100000000;

CameraModel ShiftedBarrelCamera() {
  CameraModel camera = SmallCamera();
  camera.k1 = -0.2;
  camera.p1 = 0.001;
  camera.cx += 3.2;
  return camera;
}

ExposedFrame Expose(const MjModelPtr& model, const CameraModel& camera, const ExposureOptions& options,
                    const Flight& flight) {
  EglContext gl;
  Renderer renderer(model.get());
  ExposingCamera exposing(model.get(), "camera.left", camera, {options, 4, false, 0});
  return exposing.Expose(renderer, RecordFlight(model.get(), flight, 0, 0.2), kStamp, {}, RandomStream(1, "noise"));
}

/// Largest difference between the vectors of a frame and those of points followed one by one from `open` to `close`.
double WorstError(const ExposedFrame& frame, const CameraModel& camera, const Pose& open, const Pose& close) {
  double worst = 0;
  for (int v = 0; v < camera.height_px; v += 5) {
    for (int u = 0; u < camera.width_px; u += 5) {
      const double z = frame.truth.depth.at<float>(v, u);
      const Eigen::Vector3d p_W = frame.truth.X_WC * (z * camera.Unproject({double(u), double(v)}));
      const auto from = camera.Project(open.Inverse() * p_W), to = camera.Project(close.Inverse() * p_W);
      const cv::Vec2f vector = frame.truth.blur.at<cv::Vec2f>(v, u);
      worst = std::max(worst, (Eigen::Vector2d(vector[0], vector[1]) - (*to - *from)).norm());
    }
  }
  return worst;
}

TEST(BlurField, VectorsAreTheMotionOfThePointsSeen) {
  const MjModelPtr model = SpeckledRoom();
  const Flight flight = ConstantTwist(LookingAlongX({0, 0, 0.4}), {0.2, -0.1, 0.4}, {0.4, 1.5, -0.8});
  for (const CameraModel& camera : {SmallCamera(), ShiftedBarrelCamera()}) {
    const ExposedFrame frame = Expose(model, camera, ExposureOptions(), flight);
    EXPECT_GT(frame.truth.blur_max_px, 4);
    // Single precision in the vectors, 1 um of chord in the poses.
    EXPECT_LE(WorstError(frame, camera, frame.truth.X_WC_open, frame.truth.X_WC_close), 2e-3);
    EXPECT_LE(WorstError(frame, camera, flight(0.09), flight(0.11)), 2e-3);
  }
}

TEST(BlurField, VectorsOfKnownPoints) {
  // A wall square to the optical axis at 0.99 m and a camera that moves sideways: f v t / Z everywhere.
  const MjModelPtr model = FlyerModel("<geom type='box' pos='1 0 0' size='0.01 3 3'/>");
  const CameraModel camera = SmallCamera();
  ExposureOptions options;
  options.exposure_ms = 30;
  const ExposedFrame frame =
      Expose(model, camera, options, ConstantTwist(LookingAlongX({0, 0, 0}), {0.5, 0, 0}, {0, 0, 0}));
  const double expected = -camera.fx * 0.5 * 0.030 / 0.99;
  for (const cv::Point pixel : {cv::Point(0, 0), cv::Point(80, 60), cv::Point(159, 119)}) {
    EXPECT_NEAR(frame.truth.blur.at<cv::Vec2f>(pixel)[0], expected, 1e-3);
    EXPECT_NEAR(frame.truth.blur.at<cv::Vec2f>(pixel)[1], 0, 1e-3);
  }
  EXPECT_NEAR(frame.truth.blur_median_px, -expected, 1e-3);
  EXPECT_NEAR(frame.truth.blur_p90_px, -expected, 1e-3);
  EXPECT_NEAR(frame.truth.blur_max_px, -expected, 1e-3);
}

TEST(BlurField, WhatMovesWithTheCameraIsNotBlurred) {
  const MjModelPtr model = FlyerModel("<geom type='box' pos='2 0 0' size='0.01 3 3'/>", "", {},
                                      "<geom type='box' pos='0 0.1 0.5' size='0.05 0.05 0.05'/>");
  const CameraModel camera = SmallCamera();
  const ExposedFrame frame =
      Expose(model, camera, ExposureOptions(), ConstantTwist(LookingAlongX({0, 0, 0}), {0, 0, 0}, {0, 1, 0}));
  const Eigen::Vector2d box = *camera.Project({0, 0.1, 0.45});
  EXPECT_NEAR(frame.truth.depth.at<float>(int(box.y()), int(box.x())), 0.45, 0.01);
  EXPECT_NEAR(cv::norm(frame.truth.blur.at<cv::Vec2f>(int(box.y()), int(box.x()))), 0, 1e-3);
  EXPECT_GT(cv::norm(frame.truth.blur.at<cv::Vec2f>(10, 10)), 2);
}

TEST(BlurField, WhatIsInfinitelyFarMovesByRotationAlone) {
  const MjModelPtr model = FlyerModel("<geom type='sphere' pos='1 0 -0.4' size='0.05'/>");
  const CameraModel camera = SmallCamera();
  const ExposedFrame frame =
      Expose(model, camera, ExposureOptions(),
             ConstantTwist(LookingAlongX({0, 0, 0}) * Pose(RotY(-0.05), {0, 0, 0}), {1, 0, 0}, {0, 0.5, 0}));
  EXPECT_EQ(frame.truth.depth.at<float>(60, 80), 0);
  const double angle = 0.5 * 0.020;
  EXPECT_NEAR(frame.truth.blur.at<cv::Vec2f>(60, 80)[0], -2 * camera.fx * std::tan(0.5 * angle), 5e-3);
}

TEST(BlurField, RowsOfARollingShutterHaveTheirOwnInterval) {
  // The yaw rate grows with time, so lower rows, read later, move further.
  const MjModelPtr model = SpeckledRoom();
  const CameraModel camera = SmallCamera();
  ExposureOptions options;
  options.exposure_ms = 5;
  options.readout_ms = 40;
  const auto yaw = [](double t) { return 10 * t * t; };
  const Flight flight = [&](double t) {
    return LookingAlongX({0, 0, 0.4}) * Pose(RotY(yaw(t) - yaw(0.1)), Eigen::Vector3d::Zero());
  };
  const ExposedFrame frame = Expose(model, camera, options, flight);
  for (const int row : {3, 60, 116}) {
    const double t = 0.1 + 0.040 * (row / 119.0 - 0.5);
    const double turned = yaw(t + 0.0025) - yaw(t - 0.0025);
    // 64 bands of rows share an interval: 0.2 ms off, 10 * 2 * 0.2e-3 of 2 rad/s; and chords of 2 ms.
    EXPECT_NEAR(-frame.truth.blur.at<cv::Vec2f>(row, 80)[0] / (camera.fx * turned), 1, 0.01) << row;
  }
}

TEST(MeasurePaths, APathThereAndBackIsLongerThanItsNetMotion) {
  const CameraModel camera = SmallCamera();
  cv::Mat rays(1, 1, CV_32FC2, cv::Scalar(0, 0)), depth(1, 1, CV_32FC1, cv::Scalar(2));
  SceneInstant middle;
  middle.X_WB.resize(1);
  SceneInstant left = middle, right = middle;
  left.X_WC.translation.x() = -0.1;
  right.X_WC.translation.x() = 0.1;
  const SeenPoints points(rays, depth, cv::Mat(), middle, 1);
  const PathLengths there_and_back = MeasurePaths(camera, points, {left, right, left});
  EXPECT_NEAR(there_and_back.max_px, 2 * camera.fx * 0.2 / 2, 1e-9);
}

}  // namespace
}  // namespace gaitcam
