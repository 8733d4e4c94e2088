#include "scenarios/code/datasets/frame_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

Eigen::Matrix3d ReadHomography(const fs::path& file) {
  TextTable table(file, ' ');
  Eigen::Matrix3d H;
  for (int row = 0; row < 3; ++row) {
    EXPECT_TRUE(table.Next());
    for (int column = 0; column < 3; ++column) H(row, column) = table.Number(size_t(column), "an entry");
  }
  return H;
}

/// Ideal pixels of distorted ones: what the homography is about.
Eigen::Vector3d Undistorted(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  return camera.K() * camera.Unproject(pixel);
}

/// Records a real walk, pairs it, and holds the written homographies against what depth and poses say of every fourth
/// floor pixel. @returns how many were compared.
int ExpectFloorMapsAsDepthAndPoseSay(const std::vector<std::string>& changes, const std::string& format) {
  const TemporaryFolder temporary;
  const RecordedWalk walk = ReadRecordedWalk(RecordTinyWalk(temporary.path(), format, changes));
  PairOptions options;
  options.every = 4;
  options.gap = 2;
  EXPECT_EQ(WriteFramePairs(walk, options), 5);  // 20 frames: from 0, 4, 8, 12, 16
  const CameraModel& camera = walk.calibration.camera;
  int compared = 0;
  double worst_px = 0;
  for (size_t a = 0; a + 2 < walk.frames.size(); a += 4) {
    const RecordedFrame &frame_a = walk.frames[a], &frame_b = walk.frames[a + 2];
    char name[32];
    std::snprintf(name, sizeof name, "%06zu_%06zu", a, a + 2);
    const Eigen::Matrix3d H = ReadHomography(walk.folders.truth / "pairs" / name / "H_floor.txt");
    const cv::Mat depth = ReadTrueDepth(walk, frame_a);
    for (int v = 0; v < depth.rows; v += 4) {
      for (int u = 0; u < depth.cols; u += 4) {
        const Eigen::Vector2d pixel(u, v);
        const Eigen::Vector3d p_W = frame_a.X_WC * Eigen::Vector3d(depth.at<float>(v, u) * camera.Unproject(pixel));
        if (!(depth.at<float>(v, u) > 0) || std::abs(p_W.z()) > 0.001) continue;
        const auto in_b = camera.Project(frame_b.X_WC.Inverse() * p_W);
        if (!in_b || !camera.Contains(*in_b)) continue;
        const Eigen::Vector2d mapped = (H * Undistorted(camera, pixel)).hnormalized();
        worst_px = std::max(worst_px, (mapped - Undistorted(camera, *in_b).hnormalized()).norm());
        ++compared;
      }
    }
  }
  EXPECT_LT(worst_px, 0.5);
  return compared;
}

TEST(FramePairs, TheFloorsHomographyMapsAsDepthAndPoseSay) {
  EXPECT_GT(ExpectFloorMapsAsDepthAndPoseSay({}, "tum"), 500);
}

TEST(FramePairs, WithADistortedLensItMapsUndistortedPixels) {
  EXPECT_GT(ExpectFloorMapsAsDepthAndPoseSay({"camera.lens.k1=-0.15", "camera.lens.p1=0.002"}, "euroc"), 500);
}

TEST(FramePairs, ItsInverseIsTheHomographyBack) {
  CameraModel camera = CameraModel::FromHorizontalFov(320, 240, 60);
  Eigen::Matrix3d forward;
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Pose X_WA(forward * RotX(-0.2), {0, 0, 0.3}), X_WB(RotZ(0.1) * forward * RotX(-0.25), {0.05, 0.02, 0.31});
  const Eigen::Matrix3d there = FloorHomography(camera, X_WA, X_WB), back = FloorHomography(camera, X_WB, X_WA);
  const Eigen::Matrix3d both = back * there;
  EXPECT_LT((both / both(2, 2) - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  const Eigen::Matrix3d none = FloorHomography(camera, X_WA, X_WA);
  EXPECT_LT((none - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(FramePairs, PointsAreSeenInBothFramesAndLookAlike) {
  const TemporaryFolder temporary;
  const RecordedWalk walk = ReadRecordedWalk(RecordTinyWalk(temporary.path(), "tum", {"camera.exposure_ms=0"}));
  const RecordedFrame &a = walk.frames[10], &b = walk.frames[13];
  const std::vector<TruePointPair> points =
      MatchPoints(walk.calibration.camera, a.X_WC, ReadTrueDepth(walk, a), b.X_WC, ReadTrueDepth(walk, b), 2000);
  ASSERT_GT(points.size(), 300u);
  const cv::Mat sharp_a = ReadImage(a.sharp, ""), sharp_b = ReadImage(b.sharp, "");
  // Most points show the same colour in both sharp twins, to a few grey levels: they are interpolated, and edges alias.
  size_t alike = 0, on_floor = 0;
  for (const TruePointPair& p : points) {
    const auto in_a = sharp_a.at<cv::Vec3b>(int(p.a.y()), int(p.a.x()));
    const auto in_b = sharp_b.at<cv::Vec3b>(int(std::lround(p.b.y())), int(std::lround(p.b.x())));
    alike += cv::norm(cv::Vec3d(in_a) - cv::Vec3d(in_b)) < 40;
    on_floor += p.on_floor;
    EXPECT_EQ(p.on_floor, std::abs(p.p_W.z()) < 0.002);
  }
  EXPECT_GT(double(alike), 0.9 * double(points.size()));
  EXPECT_GT(on_floor, 100u);
}

TEST(FramePairs, APointBehindSomethingIsNotMatched) {
  CameraModel camera = CameraModel::FromHorizontalFov(64, 48, 60);
  const cv::Mat wall(48, 64, CV_32FC1, cv::Scalar(2));
  cv::Mat with_box = wall.clone();
  with_box(cv::Rect(0, 0, 32, 48)) = 1;  // something stands before the left half
  const Pose here;
  EXPECT_GT(MatchPoints(camera, here, wall, here, wall, 500).size(), 300u);
  for (const TruePointPair& p : MatchPoints(camera, here, wall, here, with_box, 500)) EXPECT_GE(p.b.x(), 31);
  EXPECT_TRUE(MatchPoints(camera, here, wall, here, cv::Mat::zeros(48, 64, CV_32FC1), 500).empty());
}

TEST(FramePairs, ARecordingWithoutTruthImagesIsRefused) {
  RecordedWalk walk;
  walk.frames.resize(10);
  EXPECT_THROW(WriteFramePairs(walk, PairOptions()), BadInput);
}

}  // namespace
}  // namespace gaitcam
