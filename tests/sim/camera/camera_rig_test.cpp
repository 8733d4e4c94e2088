#include "sim/camera/camera_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

using ::testing::HasSubstr;

constexpr int kAcross = 10, kDown = 8;  // squares
constexpr double kSquare_m = 0.1;

/// A chessboard standing at x = 1 m, facing the origin; 10 x 8 squares, as the texture of a box.
MjModelPtr ChessboardScene() {
  cv::Mat board(kDown * 64, kAcross * 64, CV_8UC3);
  for (int v = 0; v < board.rows; ++v) {
    for (int u = 0; u < board.cols; ++u) {
      board.at<cv::Vec3b>(v, u) = cv::Vec3b::all((u / 64 + v / 64) % 2 == 0 ? 20 : 235);
    }
  }
  return FlyerModel("<geom type='box' pos='1 0 0' xyaxes='0 -1 0 0 0 1' size='0.5 0.4 0.01' material='board'/>",
                    "<texture name='board' type='2d' file='board.png'/>"
                    "<material name='board' texture='board' specular='0'/>",
                    {PngFile("board.png", board)});
}

/// Inner corners of the face towards the origin.
std::vector<Eigen::Vector3d> ChessboardCorners() {
  std::vector<Eigen::Vector3d> corners;
  for (int j = 1; j < kDown; ++j) {
    for (int i = 1; i < kAcross; ++i) {
      corners.emplace_back(0.99, kSquare_m * (0.5 * kAcross - i), kSquare_m * (0.5 * kDown - j));
    }
  }
  return corners;
}

CameraOptions SharpOptions() {
  CameraOptions options;
  options.width_px = 640;
  options.height_px = 480;
  options.pitch_deg = 0;
  options.exposure.noise = 0;
  return options;
}

MotionRecord StandingStill(const mjModel* model, const Pose& X_WC) {
  return RecordFlight(
      model, [&](double) { return X_WC; }, 0, 0.3);
}

struct ReprojectionError {
  double rms_px = 0, bias_px = 0;
  int corners = 0;
};

/// The corners that OpenCV finds in the image of `side` against where the camera model and the true pose put them.
ReprojectionError MeasureReprojection(const CameraOptions& options) {
  EglContext gl;
  const MjModelPtr model = ChessboardScene();
  CameraRig rig(options, 1);
  Renderer renderer(model.get(), rig.MakeRendererOptions());
  const CameraModel camera = rig.MakeCalibration().camera;
  ReprojectionError error;
  cv::Point2d sum(0, 0);
  for (int view = 0; view < 6; ++view) {
    const double side = 0.12 * (view - 2.5);
    const Pose X_WC = LookingAlongX({-0.2 + 0.06 * view, side, 0.5 * side}) *
                      Pose(RotY(0.9 * side) * RotX(-0.3 * side) * RotZ(0.1 * view), Eigen::Vector3d::Zero());
    const RigFrame frame = rig.Expose(renderer, StandingStill(model.get(), X_WC), 0, {});
    cv::Mat grey;
    cv::cvtColor(frame.left.image.pixels, grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::Point2f> expected;
    for (const Eigen::Vector3d& corner : ChessboardCorners()) {
      const auto pixel = camera.Project(X_WC.Inverse() * corner);
      if (pixel && pixel->x() > 12 && pixel->y() > 12 && pixel->x() < 627 && pixel->y() < 467) {
        expected.emplace_back(float(pixel->x()), float(pixel->y()));
      }
    }
    std::vector<cv::Point2f> found = expected;
    cv::cornerSubPix(grey, found, {4, 4}, {-1, -1}, {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4});
    for (size_t i = 0; i < found.size(); ++i) {
      const cv::Point2d difference = found[i] - expected[i];
      error.rms_px += difference.dot(difference);
      sum += difference;
    }
    error.corners += int(found.size());
  }
  error.rms_px = std::sqrt(error.rms_px / error.corners);
  error.bias_px = std::hypot(sum.x, sum.y) / error.corners;
  return error;
}

/// The bound on the RMS is the product's own; what is left is OpenCV's corner finder on sharp edges (it falls to 0.02
/// px when the image is smoothed first). The mean over 360 corners is free of that: it would show any error of
/// convention.
void ExpectExact(const ReprojectionError& error) {
  ::testing::Test::RecordProperty("rms_px", std::to_string(error.rms_px));
  ::testing::Test::RecordProperty("bias_px", std::to_string(error.bias_px));
  EXPECT_GT(error.corners, 300);
  EXPECT_LE(error.rms_px, 0.05);
  EXPECT_LE(error.bias_px, 0.01);
}

TEST(CameraRig, ChessboardCornersLieWhereTheCameraModelPutsThem) { ExpectExact(MeasureReprojection(SharpOptions())); }

TEST(CameraRig, ChessboardCornersLieWhereAnOffCentreCameraPutsThem) {
  CameraOptions options = SharpOptions();
  options.lens.cx_offset_px = -23.7;
  options.lens.cy_offset_px = 31.4;
  ExpectExact(MeasureReprojection(options));
}

TEST(CameraRig, ChessboardCornersLieWhereABarrelLensPutsThem) {
  CameraOptions options = SharpOptions();
  options.lens.k1 = -0.28;
  options.lens.k2 = 0.07;
  options.lens.p1 = 0.0008;
  options.lens.p2 = -0.0005;
  options.lens.cx_offset_px = 7.3;
  options.lens.cy_offset_px = -4.6;
  ExpectExact(MeasureReprojection(options));
}

TEST(CameraRig, ChessboardCornersLieWhereAPincushionLensPutsThem) {
  CameraOptions options = SharpOptions();
  options.lens.k1 = 0.15;
  ExpectExact(MeasureReprojection(options));
}

TEST(CameraRig, SameSeedSameBytesWhateverWasFilmedBefore) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  CameraOptions options;
  options.width_px = 96;
  options.height_px = 64;
  const MotionRecord record =
      RecordFlight(model.get(), ConstantTwist(LookingAlongX({0, 0, 0.4}), {0.1, 0, 0}, {0.2, 0.5, 0.1}), 0, 0.5);
  Renderer renderer(model.get());
  CameraRig all(options, 7), last_only(options, 7), other_seed(options, 8);
  RigFrame frame;
  for (int i = 0; i < 4; ++i) frame = all.Expose(renderer, record, i, {});
  const RigFrame again = last_only.Expose(renderer, record, 3, {});
  EXPECT_EQ(cv::norm(frame.left.image.pixels, again.left.image.pixels, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(frame.left.truth.sharp, again.left.truth.sharp, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(frame.left.truth.blur, again.left.truth.blur, cv::NORM_INF), 0);
  const RigFrame noise = other_seed.Expose(renderer, record, 3, {});
  EXPECT_GT(cv::norm(frame.left.image.pixels, noise.left.image.pixels, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(frame.left.truth.sharp, noise.left.truth.sharp, cv::NORM_INF), 0);
}

TEST(CameraRig, FramesAreEvenlySpacedAndTheFirstShutterOpensAtZero) {
  CameraOptions options;
  options.rate_hz = 30;
  options.exposure.exposure_ms = 20;
  options.exposure.readout_ms = 10;
  const CameraRig rig(options, 1);
  EXPECT_EQ(rig.Shutter(rig.FrameStamp(0)).open_ns, 0);
  EXPECT_EQ(rig.FrameStamp(0), 15000000);
  EXPECT_EQ(rig.MakeCalibration().readout_ms, 10);
  EXPECT_EQ(rig.FrameStamp(300) - rig.FrameStamp(0), 10000000000);  // no drift from rounding 1/30 s
}

TEST(CameraRig, TheRightCameraStandsABaselineToTheRight) {
  EglContext gl;
  // The right camera is a second one on the flyer, put where the rig asks for it.
  CameraOptions options;
  options.width_px = 320;
  options.height_px = 240;
  options.pitch_deg = 0;
  options.exposure.noise = 0;
  options.stereo.baseline_m = 0.1;
  CameraRig rig(options, 1);
  const std::vector<WorldCamera> cameras = rig.WorldCameras();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].name, "camera.right");
  const Eigen::Vector3d p = cameras[1].X_MC.translation;
  EXPECT_NEAR((p - Eigen::Vector3d(0.1, 0, 0)).norm(), 0, 1e-12);
  const MjModelPtr model = FlyerModel("<geom type='sphere' pos='2 0 0' size='0.05' rgba='1 1 1 1'/>", "", {},
                                      "<camera name='camera.right' pos='0.1 0 0' xyaxes='1 0 0 0 -1 0'/>");
  Renderer renderer(model.get());
  const RigFrame frame = rig.Expose(renderer, StandingStill(model.get(), LookingAlongX({0, 0, 0})), 0, {});
  ASSERT_TRUE(frame.right.has_value());
  const auto column = [](const cv::Mat& image) {
    const cv::Moments m = cv::moments(image.reshape(1, image.rows).colRange(0, image.cols * 3), false);
    return (m.m10 / m.m00 - 1) / 3;  // channels lie side by side
  };
  // Disparity f b / Z, up to 1 % for the sphere's outline not being its centre.
  const double disparity = column(frame.left.image.pixels) - column(frame.right->image.pixels);
  EXPECT_NEAR(disparity, rig.MakeCalibration().camera.fx * 0.1 / 2, 0.15);
}

TEST(CameraRig, PositivePitchLooksDown) {
  CameraOptions options;
  options.pitch_deg = 10;
  const Eigen::Vector3d forward = CameraRig(options, 1).WorldCameras()[0].X_MC.R().col(2);
  EXPECT_NEAR(forward.y(), std::sin(10 * M_PI / 180), 1e-12);  // y is down
}

TEST(CameraRig, TheDepthImageIsThatOfMidExposure) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  CameraOptions options;
  options.width_px = 64;
  options.height_px = 48;
  options.depth = true;
  CameraRig rig(options, 1);
  Renderer renderer(model.get());
  TruthOptions none;
  none.sharp = none.depth = none.blur = false;
  const RigFrame frame = rig.Expose(renderer, StandingStill(model.get(), LookingAlongX({0, 0, 0.5})), 0, none);
  ASSERT_TRUE(frame.depth.has_value());
  EXPECT_EQ(frame.depth->stamp_ns, frame.left.image.stamp_ns);
  EXPECT_NEAR(frame.depth->pixels.at<float>(10, 32), 1.99, 1e-4);  // the wall's face
}

TEST(CameraRig, ADepthModelSpoilsTheMeasuredDepthAlone) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  Renderer renderer(model.get());
  const MotionRecord record = StandingStill(model.get(), LookingAlongX({0, 0, 0.5}));
  CameraOptions options;
  options.width_px = 64;
  options.height_px = 48;
  options.depth = true;
  const RigFrame ideal = CameraRig(options, 1).Expose(renderer, record, 1, {});
  for (const DepthModel depth_model : {DepthModel::kStructuredLight, DepthModel::kTimeOfFlight}) {
    options.depth_model = depth_model;
    CameraRig rig(options, 1);
    EXPECT_GT(rig.MakeCalibration().depth.Sigma(2), 0);
    const RigFrame frame = rig.Expose(renderer, record, 1, {});
    EXPECT_EQ(cv::norm(frame.left.image.pixels, ideal.left.image.pixels, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(frame.left.truth.depth, ideal.left.truth.depth, cv::NORM_INF), 0);
    EXPECT_GT(cv::norm(frame.depth->pixels, ideal.depth->pixels, cv::NORM_INF), 0);
    const RigFrame next = rig.Expose(renderer, record, 2, {});
    EXPECT_GT(cv::norm(frame.depth->pixels, next.depth->pixels, cv::NORM_INF), 0) << "noise of its own";
  }
}

std::string Refusal(const CameraOptions& options) {
  try {
    CameraRig rig(options, 1);
  } catch (const BadOption& error) {
    return error.what();
  }
  return "";
}

TEST(CameraRig, ADepthCameraOfItsOwnLooksLaterAndIsRegistered) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  Renderer renderer(model.get());
  CameraOptions options;
  options.width_px = 160;
  options.height_px = 120;
  options.depth = true;
  options.depth_mount = DepthMountOptions{0.025, 30, 0, 0};
  CameraRig rig(options, 1);
  const double forward_mps = 2;
  const MotionRecord record =
      RecordFlight(model.get(), ConstantTwist(LookingAlongX({-0.5, 0, 0.5}), {0, 0, forward_mps}, {0, 0, 0}), 0, 0.1);
  const int64_t stamp_ns = rig.FrameStamp(0);
  EXPECT_GE(rig.Shutter(stamp_ns).close_ns, stamp_ns + 30'000'000) << "the record must reach so far";
  const RigFrame frame = rig.Expose(renderer, record, 0, {});
  EXPECT_EQ(frame.depth->stamp_ns, frame.left.image.stamp_ns + 30'000'000);
  // The wall straight ahead has come nearer by 2 m/s x 30 ms; it is flat, so that the place beside makes no difference.
  const int row = 20, column = 80;
  EXPECT_NEAR(frame.depth->pixels.at<float>(row, column), frame.left.truth.depth.at<float>(row, column) - 0.06, 2e-3);
  EXPECT_NEAR(frame.left.truth.depth.at<float>(row, column), 2.49 - forward_mps * 1e-9 * double(stamp_ns), 2e-3)
      << "the truth is the left camera's";

  options.depth_mount = DepthMountOptions{0.025, 0, 0, 0};
  const auto filmed = [&](uint64_t seed, double error_deg) {
    options.depth_mount->error_deg = error_deg;
    return CameraRig(options, seed).Expose(renderer, record, 0, {}).depth->pixels;
  };
  EXPECT_EQ(cv::norm(filmed(1, 0), filmed(2, 0), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(filmed(1, 1), filmed(2, 1), cv::NORM_INF), 0) << "each rig errs in its own way";
  EXPECT_EQ(cv::norm(filmed(1, 1), filmed(1, 1), cv::NORM_INF), 0);
}

TEST(CameraRig, RefusesAMountWithoutADepthCamera) {
  CameraOptions options;
  options.depth_mount.emplace();
  EXPECT_THAT(Refusal(options), HasSubstr("camera.depth_mount: there is no depth camera to mount"));
  options.depth = true;
  EXPECT_EQ(Refusal(options), "");
}

TEST(CameraRig, RefusesAnExposureLongerThanTheFramePeriod) {
  CameraOptions options;
  options.rate_hz = 50;
  options.exposure.exposure_ms = 20.5;
  EXPECT_THAT(Refusal(options), HasSubstr("camera.exposure_ms: 20.5"));
  EXPECT_THAT(Refusal(options), HasSubstr("at most the frame period of 20 ms"));
}

TEST(CameraRig, RefusesALensThatFoldsThePicture) {
  CameraOptions options;
  options.hfov_deg = 100;
  options.lens.k1 = -0.5;
  EXPECT_THAT(Refusal(options), HasSubstr("camera distortion"));
}

TEST(CameraRig, DefaultsAreValid) { EXPECT_EQ(Refusal(CameraOptions()), ""); }

}  // namespace
}  // namespace gaitcam
