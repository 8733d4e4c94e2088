// Regions proposed in drawn pictures whose parts are known.

#include "algorithms/planes/putative_planes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kCoarse_grey = 30;  // of texture that a camera resolves

cv::Mat Flat(int grey) { return {kHeight, kWidth, CV_8UC1, cv::Scalar(double(grey))}; }

/// Independent noise of a sensor. @param smooth_px 0: none; more: texture of about that size instead.
cv::Mat WithNoise(const cv::Mat& image, double sigma_grey, uint64_t seed, double smooth_px = 0) {
  RandomStream random(seed, "noise");
  cv::Mat noise(image.size(), CV_32FC1), sum, result;
  for (int i = 0; i < int(noise.total()); ++i) noise.at<float>(i / noise.cols, i % noise.cols) = float(random.Normal());
  if (smooth_px > 0) {
    cv::GaussianBlur(noise, noise, {}, smooth_px);
    cv::Scalar mean, deviation;
    cv::meanStdDev(noise, mean, deviation);
    noise /= deviation[0];
  }
  image.convertTo(sum, CV_32F);
  sum += sigma_grey * noise;
  sum.convertTo(result, CV_8U);
  return result;
}

PutativePlaneOptions Only(RegionSelector selector) {
  PutativePlaneOptions options;
  options.selector = selector;
  return options;
}

cv::Mat Filled(const std::vector<cv::Point>& polygon) {
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{polygon}, cv::Scalar(255));
  return mask;
}

double IntersectionOverUnion(const cv::Mat& a, const cv::Mat& b) {
  return double(cv::countNonZero(a & b)) / double(cv::countNonZero(a | b));
}

cv::Mat Pixels(const PutativePlane& plane) { return UnionOfPixels({plane}, {kWidth, kHeight}); }
cv::Mat Enclosed(const PutativePlane& plane) { return UnionOfEnclosed({plane}, {kWidth, kHeight}); }

/// Share of `part` that lies in `whole`.
double Inside(const cv::Mat& part, const cv::Mat& whole) {
  return double(cv::countNonZero(part & whole)) / double(std::max(1, cv::countNonZero(part)));
}

const std::vector<cv::Point> kPolygon{{60, 60}, {230, 40}, {280, 190}, {90, 200}};

cv::Mat PolygonPicture() {
  cv::Mat image = Flat(90);
  image.setTo(150, Filled(kPolygon));
  return image;
}

TEST(PutativePlanes, AUniformRegionIsFoundWithABandAlongItsBoundary) {
  const std::vector<PutativePlane> planes =
      FindPutativePlanes(WithNoise(PolygonPicture(), 3, 1), Only(RegionSelector::kBoundary));
  ASSERT_EQ(planes.size(), 2U);  // the ground around it, and it
  EXPECT_EQ(planes[1].kind, PutativePlane::Kind::kBoundary);
  const cv::Mat truth = Filled(kPolygon);
  // Canny's line takes a pixel on one side or the other: 550 px of outline on 26 000 px of area are 2 %.
  EXPECT_GT(IntersectionOverUnion(Enclosed(planes[1]), truth), 0.96);
  EXPECT_NEAR(planes[1].area_px, cv::countNonZero(truth), 1000);
  cv::Mat distance, outline = cv::Mat::zeros(truth.size(), CV_8UC1);
  cv::polylines(outline, kPolygon, true, cv::Scalar(255));
  cv::distanceTransform(outline == 0, distance, cv::DIST_L2, 3);
  cv::Mat near = distance <= 1, far = distance > 6;
  EXPECT_GT(Inside(near, Pixels(planes[1])), 0.99);  // the outline itself is covered
  EXPECT_EQ(cv::countNonZero(far & Pixels(planes[1])), 0);
  const double thickness = cv::countNonZero(planes[1].pixels) / cv::arcLength(kPolygon, true);
  EXPECT_NEAR(thickness, 6, 1.2);  // squares reach farther along slanting lines, by up to 1 / cos 45 degrees
}

TEST(PutativePlanes, TheRimOfTheImageIsNoBoundary) {
  cv::Mat image = Flat(90);
  image(cv::Rect(0, 120, kWidth, kHeight - 120)) = 160;
  const std::vector<PutativePlane> planes = FindPutativePlanes(image, Only(RegionSelector::kBoundary));
  ASSERT_EQ(planes.size(), 2U);
  for (const PutativePlane& plane : planes) {
    EXPECT_EQ(cv::countNonZero(Pixels(plane).rowRange(0, 112)), 0);
    EXPECT_EQ(cv::countNonZero(Pixels(plane).rowRange(128, kHeight)), 0);
    EXPECT_NEAR(cv::countNonZero(plane.pixels) / double(kWidth), 6, 1.01);
  }
}

TEST(PutativePlanes, AnOutlineWithASmallGapStillEncloses) {
  cv::Mat image = Flat(120);
  cv::polylines(image, kPolygon, true, cv::Scalar(30), 2);
  cv::line(image, {145, 50}, {147, 50}, cv::Scalar(120), 4);  // breaks the upper side
  PutativePlaneOptions options = Only(RegionSelector::kBoundary);
  const auto finds_it = [&] {
    for (const PutativePlane& plane : FindPutativePlanes(image, options)) {
      if (IntersectionOverUnion(Enclosed(plane), Filled(kPolygon)) > 0.9) return true;
    }
    return false;
  };
  options.closing_px = 4;
  EXPECT_TRUE(finds_it());
  cv::line(image, {135, 51}, {160, 49}, cv::Scalar(120), 8);  // 25 px are too many
  EXPECT_FALSE(finds_it());
}

TEST(PutativePlanes, SmallRegionsAreLeftOut) {
  cv::Mat image = Flat(90);
  cv::rectangle(image, cv::Rect(100, 100, 20, 20), cv::Scalar(200), cv::FILLED);
  const std::vector<PutativePlane> planes = FindPutativePlanes(image, Only(RegionSelector::kBoundary));
  ASSERT_EQ(planes.size(), 1U);  // the ground, whose boundary is that of the small one
  EXPECT_GT(planes[0].area_px, kWidth * kHeight - 500);
  EXPECT_GT(cv::countNonZero(Pixels(planes[0])(cv::Rect(90, 90, 40, 40))), 0);
}

TEST(PutativePlanes, TextureIsFoundWhereItIsAndNowhereElse) {
  const cv::Mat textured = WithNoise(Flat(128), kCoarse_grey, 2, 2.0);
  for (const cv::Rect half : {cv::Rect(0, 0, 160, 240), cv::Rect(0, 120, 320, 120)}) {
    cv::Mat image = WithNoise(Flat(128), 3, 3);
    textured(half).copyTo(image(half));
    const std::vector<PutativePlane> planes = FindPutativePlanes(image, Only(RegionSelector::kTexture));
    EXPECT_GE(planes.size(), 6U);  // blocks, each to be judged by itself
    const cv::Mat found = UnionOfPixels(planes, image.size());
    cv::Mat truth = cv::Mat::zeros(image.size(), CV_8UC1);
    truth(half) = 255;
    // Density is counted in a window of 21 px, so that the seam is off by a few pixels; the cuts take 1 / 64 each way.
    EXPECT_GT(Inside(truth, found), 0.9);
    EXPECT_GT(Inside(found, truth), 0.96);
  }
}

TEST(PutativePlanes, PartsOfATexturedRegionFitTheirBlocksAndDoNotOverlap) {
  const cv::Mat image = WithNoise(Flat(128), kCoarse_grey, 4, 2.0);
  const PutativePlaneOptions options = Only(RegionSelector::kTexture);
  cv::Mat count = cv::Mat::zeros(image.size(), CV_8UC1);
  for (const PutativePlane& plane : FindPutativePlanes(image, options)) {
    EXPECT_EQ(plane.kind, PutativePlane::Kind::kTexture);
    const cv::Rect box = cv::boundingRect(Pixels(plane));
    EXPECT_EQ(box.x / options.block_px, (box.x + box.width - 1) / options.block_px);
    EXPECT_EQ(box.y / options.block_px, (box.y + box.height - 1) / options.block_px);
    count(plane.at) += plane.pixels / 255;
  }
  double most = 0;
  cv::minMaxLoc(count, nullptr, &most);
  EXPECT_EQ(most, 1);
}

TEST(PutativePlanes, NoiseAloneGivesNothing) {
  for (const double sigma : {0.0, 2.0, 5.0}) {
    for (const int grey : {20, 128, 240}) {
      EXPECT_TRUE(FindPutativePlanes(WithNoise(Flat(grey), sigma, 5)).empty()) << sigma << " on " << grey;
    }
  }
}

TEST(PutativePlanes, AStepOfLightIsABoundaryAndNoTexture) {
  EXPECT_FALSE(FindPutativePlanes(PolygonPicture(), Only(RegionSelector::kBoundary)).empty());
  EXPECT_TRUE(FindPutativePlanes(PolygonPicture(), Only(RegionSelector::kTexture)).empty());
}

TEST(PutativePlanes, AreSortedAndTheSameEveryTime) {
  cv::Mat image = PolygonPicture();
  WithNoise(Flat(128), kCoarse_grey, 6, 2.0)(cv::Rect(200, 120, 120, 120)).copyTo(image(cv::Rect(200, 120, 120, 120)));
  const std::vector<PutativePlane> once = FindPutativePlanes(image), twice = FindPutativePlanes(image);
  ASSERT_EQ(once.size(), twice.size());
  ASSERT_GE(once.size(), 3U);
  for (size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(cv::countNonZero(Pixels(once[i]) != Pixels(twice[i])), 0);
    EXPECT_EQ(once[i].area_px, cv::countNonZero(once[i].enclosed));
    if (i > 0) {
      EXPECT_GE(once[i - 1].area_px, once[i].area_px);
    }
  }
}

TEST(PutativePlanes, ColourIsTakenForItsGrey) {
  const cv::Mat grey = WithNoise(PolygonPicture(), kCoarse_grey, 7, 2.0);
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  const std::vector<PutativePlane> a = FindPutativePlanes(grey), b = FindPutativePlanes(colour);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(cv::countNonZero(Pixels(a[i]) != Pixels(b[i])), 0);
}

std::string WhatIsSaid(const cv::Mat& image, const PutativePlaneOptions& options) {
  try {
    FindPutativePlanes(image, options);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

TEST(PutativePlanes, BadInputIsNamed) {
  EXPECT_THAT(WhatIsSaid(cv::Mat(20, 320, CV_8UC1, cv::Scalar(0)), {}), HasSubstr("320 x 20"));
  EXPECT_THAT(WhatIsSaid(cv::Mat(), {}), HasSubstr("32 px"));
  EXPECT_THAT(WhatIsSaid(cv::Mat(240, 320, CV_32FC1, cv::Scalar(0)), {}), HasSubstr("8-bit"));
  PutativePlaneOptions options;
  options.canny_low = 90;
  EXPECT_THAT(WhatIsSaid(Flat(128), options), HasSubstr("canny_low"));
}

}  // namespace
}  // namespace gaitcam
