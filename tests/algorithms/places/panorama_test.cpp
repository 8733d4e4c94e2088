#include "algorithms/places/panorama.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cylinder_world.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
constexpr double kDeg = std::numbers::pi / 180;

CameraModel DistortedCamera() {
  CameraModel camera = Ers7Camera();
  camera.k1 = -0.18, camera.k2 = 0.05, camera.p1 = 0.002, camera.p2 = -0.001;
  camera.cx += 3, camera.cy -= 2;
  return camera;
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_L1) / double(a.total()); }

/// Frames every `step_deg`, clockwise.
Panorama Stitch(const CylinderWorld& world, const CameraModel& camera, const Eigen::Vector3d& up,
                const PanoramaLayout& layout, double step_deg) {
  const CylinderProjection projection(camera, up, layout);
  PanoramaBuilder builder(projection, layout);
  for (double yaw = 180; yaw > -180; yaw -= step_deg) builder.Add(world.View(camera, up, yaw * kDeg), yaw * kDeg);
  return builder.Finish();
}

TEST(PanoramaLayout, PutsStraightAheadInTheMiddleAndLeftOfStraightBackAtColumn0) {
  PanoramaLayout layout;
  EXPECT_DOUBLE_EQ(layout.AzimuthOf(359.5), 0);
  EXPECT_NEAR(layout.AzimuthOf(0), std::numbers::pi - 0.25 * kDeg, 1e-12);
  EXPECT_DOUBLE_EQ(layout.ColumnOf(layout.AzimuthOf(17)), 17);
  EXPECT_GT(layout.TanElevationOf(0), layout.TanElevationOf(1));
}

TEST(PanoramaLayout, ForACameraIsFilledByItsView) {
  for (const double pitch : {-10.0, 0.0, 8.0, 20.0}) {
    for (const int width : {720, 1830}) {
      const PanoramaLayout layout = LayoutFor(Ers7Camera(), UpOf(pitch), width, 160);
      const CylinderProjection projection(Ers7Camera(), UpOf(pitch), layout);
      // A view of 56.9 degrees loses little at its sides, and nothing is made up: every pixel lies in the image.
      EXPECT_GT(projection.width_px(), 0.7 * width * 56.9 / 360) << pitch;
      const cv::Mat white(160, 208, CV_8UC1, cv::Scalar(255));
      EXPECT_EQ(cv::countNonZero(projection.ProjectView(white) != 255), 0);
    }
  }
}

TEST(CylinderProjection, ShowsAViewAsThePanoramaShowsItsDirection) {
  const CylinderWorld world(4);
  for (const CameraModel& camera : {Ers7Camera(), DistortedCamera()}) {
    const Eigen::Vector3d up = UpOf(7);
    const PanoramaLayout layout = LayoutFor(camera, up, 720, 160);
    const CylinderProjection projection(camera, up, layout);
    const cv::Mat view = projection.ProjectView(world.View(camera, up, 30 * kDeg));
    cv::Mat expected(view.size(), CV_8UC1);
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.cols; ++x) {
        const double azimuth = 30 * kDeg + (0.5 * (view.cols - 1) - x) / layout.px_per_rad();
        expected.at<uchar>(y, x) = cv::saturate_cast<uchar>(world.At(azimuth, layout.TanElevationOf(y)));
      }
    }
    // Interpolated twice over drawn edges of up to 230 grey levels.
    EXPECT_LT(MeanDifference(view, expected), 1.0);
  }
}

TEST(CylinderProjection, AveragesImagesMuchFinerThanThePanorama) {
  const CylinderWorld world(4);
  const CameraModel camera = CameraModel::FromHorizontalFov(832, 640, 56.9);
  const PanoramaLayout layout = LayoutFor(camera, UpOf(7), 720, 160);
  const CylinderProjection projection(camera, UpOf(7), layout);
  const cv::Mat view = projection.ProjectView(world.View(camera, UpOf(7), 0));
  const int first = int(std::lround(layout.ColumnOf(0.5 * (view.cols - 1) / layout.px_per_rad())));
  EXPECT_LT(MeanDifference(view, world.Panorama(layout).colRange(first, first + view.cols)), 4.0);
}

TEST(PanoramaBuilder, StitchesTheWorldThatTheFramesShow) {
  const CylinderWorld world(5);
  for (const double step_deg : {1.0, 7.0, 20.0}) {
    const Eigen::Vector3d up = UpOf(6);
    const PanoramaLayout layout = LayoutFor(DistortedCamera(), up, 720, 160);
    const Panorama panorama = Stitch(world, DistortedCamera(), up, layout, step_deg);
    EXPECT_NEAR(panorama.frames, 360 / step_deg, 4);  // none is taken between two that are near enough
    EXPECT_LT(MeanDifference(panorama.image, world.Panorama(layout)), 1.5) << step_deg;
    EXPECT_GT(panorama.seams_px.size(), 10u);
    EXPECT_LT(panorama.mean_seam_error_px, 0.1);  // perfect input: what remains is the interpolation's
    EXPECT_NEAR(panorama.gain_spread, 1, 0.01);
  }
}

TEST(PanoramaBuilder, MeasuresByHowMuchAFrameIsOutOfPlace) {
  const CylinderWorld world(5);
  const Eigen::Vector3d up = UpOf(6);
  const PanoramaLayout layout = LayoutFor(Ers7Camera(), up, 720, 160);
  const CylinderProjection projection(Ers7Camera(), up, layout);
  PanoramaBuilder builder(projection, layout);
  const double step_deg = 12, wrong_deg = 2;  // two seams of 30, by 4 px
  for (double yaw = 180; yaw > -180; yaw -= step_deg) {
    const double seen = std::abs(yaw) < 1e-6 ? yaw + wrong_deg : yaw;
    builder.Add(world.View(Ers7Camera(), up, seen * kDeg), yaw * kDeg);
  }
  const Panorama panorama = builder.Finish();
  ASSERT_EQ(panorama.seams_px.size(), 30u);
  EXPECT_NEAR(panorama.max_seam_error_px, 4, 0.3);
  EXPECT_NEAR(panorama.mean_seam_error_px, 2 * 4.0 / 30, 0.1);
}

TEST(PanoramaBuilder, EvensOutExposureFromFrameToFrame) {
  const CylinderWorld world(6);
  const Eigen::Vector3d up = UpOf(6);
  const PanoramaLayout layout = LayoutFor(Ers7Camera(), up, 720, 160);
  const CylinderProjection projection(Ers7Camera(), up, layout);
  PanoramaBuilder builder(projection, layout);
  int k = 0;
  for (double yaw = 180; yaw > -180; yaw -= 10, ++k)
    builder.Add(world.View(Ers7Camera(), up, yaw * kDeg, k % 2 ? 0.6 : 0.9), yaw * kDeg);
  const Panorama panorama = builder.Finish();
  EXPECT_NEAR(panorama.gain_spread, 1.5, 0.03);
  const cv::Mat even = 0.7348 * world.Panorama(layout);  // the geometric mean of 0.6 and 0.9
  EXPECT_LT(MeanDifference(panorama.image, even), 2.5);
}

TEST(PanoramaBuilder, TakesTwoHalfSweepsWithATurnBetween) {
  const CylinderWorld world(8);
  const Eigen::Vector3d up = UpOf(6);
  const PanoramaLayout layout = LayoutFor(Ers7Camera(), up, 720, 160);
  const CylinderProjection projection(Ers7Camera(), up, layout);
  PanoramaBuilder builder(projection, layout);
  for (const double turn : {0.0, 180.0}) {
    for (double pan = 93; pan >= -93; pan -= 1) {
      const double yaw = (pan + turn) * kDeg;
      builder.Add(world.View(Ers7Camera(), up, yaw), yaw);
    }
    EXPECT_NEAR(builder.missing_deg(), turn == 0 ? 360 - 186 - 2 * projection.half_width_rad() / kDeg : 0, 1.5);
  }
  EXPECT_LE(builder.frames(), 362);  // what was seen before is not taken again
  EXPECT_LT(MeanDifference(builder.Finish().image, world.Panorama(layout)), 1.5);
}

TEST(PanoramaBuilder, SaysHowManyDegreesAreMissing) {
  const PanoramaLayout layout = LayoutFor(Ers7Camera(), UpOf(0), 720, 160);
  const CylinderProjection projection(Ers7Camera(), UpOf(0), layout);
  PanoramaBuilder builder(projection, layout);
  EXPECT_EQ(builder.missing_deg(), 360);
  EXPECT_THROW(builder.Finish(), TooLittleData);
  for (double yaw = -90; yaw <= 90; yaw += 5) builder.Add(cv::Mat(160, 208, CV_8UC1, cv::Scalar(9)), yaw * kDeg);
  try {
    builder.Finish();
    ADD_FAILURE();
  } catch (const TooLittleData& error) {
    EXPECT_THAT(error.what(), HasSubstr("of 360 deg unseen"));
  }
}

TEST(Panorama, RefusesWhatItCannotDo) {
  EXPECT_THROW(LayoutFor(Ers7Camera(), UpOf(75), 720, 160), BadInput);
  EXPECT_THROW(LayoutFor(Ers7Camera(), UpOf(0), 0, 160), BadOption);
  EXPECT_THROW(CylinderProjection(Ers7Camera(), UpOf(0), PanoramaLayout{720, 160, -2, 2}), BadInput);
  const CylinderProjection projection(Ers7Camera(), UpOf(0), LayoutFor(Ers7Camera(), UpOf(0), 720, 160));
  EXPECT_THROW(projection.ProjectView(cv::Mat(100, 100, CV_8UC1)), BadInput);
  EXPECT_THROW(projection.ProjectView(cv::Mat(160, 208, CV_32FC1)), BadInput);
}

}  // namespace
}  // namespace gaitcam
