#include "algorithms/features/blur_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/features/spectrum.h"
#include "algorithms/features/synthetic_blur.h"
#include "algorithms/features/wiener.h"
#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

BlurPath Straight(const Eigen::Vector2d& vector) { return {{-0.5 * vector, 0.5 * vector}}; }

TEST(BlurPath, AStraightEvenPathIsALine) {
  const LineBlur line{13, 0.6};
  const cv::Size plane(64, 48);
  const PlaneGain path = PathTransfer(Straight(line.Vector()), plane);
  ASSERT_EQ(path.rows(), plane.height);
  ASSERT_EQ(path.cols(), plane.width / 2 + 1);
  const Eigen::ArrayXf fx = Eigen::ArrayXf::LinSpaced(33, 0, 32) / 64;
  Eigen::ArrayXf h(33);
  for (int y = 0; y < plane.height; ++y) {
    LineTransfer(line).Row(fx, float(y <= 24 ? y : y - 48) / 48, h);
    for (int x = 0; x < 33; ++x) {
      EXPECT_NEAR(path(y, x).real(), h[x], 0.02);  // pieces of half a pixel are taken for points
      EXPECT_NEAR(path(y, x).imag(), 0, 1e-4);
    }
  }
}

TEST(BlurPath, AShiftIsInThePhaseAlone) {
  BlurPath path{{{-3, 1}, {2, 2}, {4, -5}}}, shifted = path;
  for (Eigen::Vector2d& p : shifted.points) p += Eigen::Vector2d(2.5, -1.25);
  const PlaneGain a = PathTransfer(path, {32, 32}), b = PathTransfer(shifted, {32, 32});
  EXPECT_LT((a.abs() - b.abs()).abs().maxCoeff(), 1e-4);
  const std::complex<float> turned = std::polar(1.f, float(-2 * M_PI * (3 / 32.0 * 2.5 + 2 / 32.0 * -1.25)));
  EXPECT_LT(std::abs(a(2, 3) * turned - b(2, 3)), 1e-4);
}

TEST(BlurPath, TheTransferIsThatOfWhatTheCameraDoes) {
  // A mean of moved images and a product with H are the same: image, not formula.
  const cv::Mat picture = Values(RandomPicture({220, 200}, 8));
  for (const BlurKind kind : {BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter}) {
    const ImageMotion motion = DrawMotion(kind, 15, picture.size(), 9);
    const Spectrum spectrum(picture, 48);
    const cv::Mat seen = spectrum.Through(PathTransfer(motion.PathAt({0, 0}), spectrum.plane_size()));
    const cv::Mat moved = BlurAlong(picture, motion);
    const cv::Rect inside(30, 30, 160, 140);  // away from the margins, which differ
    EXPECT_LT(cv::norm(seen(inside), moved(inside), cv::NORM_L2) / std::sqrt(inside.area()), 0.01) << int(kind);
  }
}

TEST(BlurPath, MiddleOfTheTimesOfAResampledPathStays) {
  const BlurPath path{{{0, 0}, {4, 0}, {4, 2}}};
  const BlurPath fine = Resampled(path, 9);
  ASSERT_EQ(fine.points.size(), 9u);
  EXPECT_LT((fine.points[4] - Eigen::Vector2d(4, 0)).norm(), 1e-12);
  EXPECT_LT((fine.points[2] - Eigen::Vector2d(2, 0)).norm(), 1e-12);
  EXPECT_NEAR(fine.Length(), 6, 1e-12);
}

TEST(BlurPath, OneMotionIsOneRegionAndATurnIsMany) {
  const cv::Size size(320, 240);
  const ImageMotion same = DrawMotion(BlurKind::kArc, 20, size, 1), turn = DrawMotion(BlurKind::kRotation, 20, size, 1);
  EXPECT_EQ(DivideByPath([&](const Eigen::Vector2d& p) { return same.PathAt(p); }, size).size(), 1u);
  PathDivisionOptions options;
  options.min_region_px = 1;
  const auto regions = DivideByPath([&](const Eigen::Vector2d& p) { return turn.PathAt(p); }, size, options);
  cv::Mat covered = cv::Mat::zeros(size, CV_8UC1);
  for (const BlurRegion& region : regions) {
    covered(region.rectangle) += 1;
    const cv::Point corner = region.rectangle.tl();
    const Eigen::Vector2d there = turn.PathAt({double(corner.x), double(corner.y)}).points.front();
    // Halves of both sides add up.
    EXPECT_LT((there - region.path.points.front()).norm(), 2 * std::max(1.0, 0.1 * region.path.Length()));
  }
  EXPECT_GT(regions.size(), 20u);
  double least = 0, most = 0;
  cv::minMaxLoc(covered, &least, &most);
  EXPECT_EQ(least, 1);
  EXPECT_EQ(most, 1);
}

double Rms(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_L2) / std::sqrt(double(a.total())); }

TEST(BlurPath, RestoringAlongThePathIsBetterThanAlongALine) {
  const cv::Mat picture = Values(RandomPicture({300, 260}, 10));
  const cv::Rect inside(30, 30, 240, 200);
  WienerOptions options;
  options.border_passes = 2;
  for (const BlurKind kind : {BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter})
    for (const uint64_t seed : {1, 2}) {
      const BlurPath path = DrawMotion(kind, 18, picture.size(), seed).PathAt({0, 0});
      const cv::Mat blurred = BlurAlong(picture, DrawMotion(kind, 18, picture.size(), seed))(inside);
      const double along = Rms(RestoreWiener(blurred, path, options), picture(inside));
      EXPECT_LT(along, 0.6 * Rms(blurred, picture(inside))) << int(kind);
      EXPECT_LT(along, 0.8 * Rms(RestoreWiener(blurred, path.Chord(), options), picture(inside))) << int(kind);
      BlurPath backwards = path;  // what a sign of the phases would do
      for (Eigen::Vector2d& p : backwards.points) p = -p;
      EXPECT_LT(along, 0.8 * Rms(RestoreWiener(blurred, backwards, options), picture(inside))) << int(kind);
    }
}

TEST(BlurPath, RegionsOfATurnAreRestoredTogether) {
  const cv::Mat picture = Values(RandomPicture({320, 260}, 11));
  const ImageMotion turn = DrawMotion(BlurKind::kRotation, 14, picture.size(), 3);
  const cv::Mat blurred = BlurAlong(picture, turn);
  const auto regions = DivideByPath([&](const Eigen::Vector2d& p) { return turn.PathAt(p); }, picture.size());
  auto across = regions;
  for (BlurRegion& region : across)
    for (Eigen::Vector2d& p : region.path.points) p = {p.y(), -p.x()};
  // Parts of two dozen pixels see little of their surroundings: less is won than by one path for all.
  EXPECT_LT(Rms(RestoreRegions(blurred, regions, {}), picture), 0.9 * Rms(blurred, picture));
  EXPECT_GT(Rms(RestoreRegions(blurred, across, {}), picture), Rms(blurred, picture));
}

}  // namespace
}  // namespace gaitcam
