#include "algorithms/features/blur_segmentation.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {
namespace {

using psf_test::Photograph;

void ExpectCovers(const std::vector<BlurRegion>& regions, const cv::Size& size) {
  cv::Mat count(size, CV_8UC1, cv::Scalar(0));
  for (const BlurRegion& region : regions) count(region.rectangle) += 1;
  EXPECT_EQ(cv::countNonZero(count == 1), size.area());
}

/// Independent grey levels, blurred one way on the left and another way on the right.
cv::Mat TwoBlurs(const LineBlur& left, const LineBlur& right) {
  RandomStream random(5, "speckle");
  cv::Mat speckle(420, 720, CV_8UC1);
  for (int y = 0; y < speckle.rows; ++y) {
    for (int x = 0; x < speckle.cols; ++x) speckle.at<uchar>(y, x) = uchar(random.Index(256));
  }
  cv::Mat image = BlurPhotograph(speckle, left, 0, 1, false, {640, 360});
  const cv::Rect half(320, 0, 320, 360);
  BlurPhotograph(speckle, right, 0, 1, false, {640, 360})(half).copyTo(image(half));
  return image;
}

TEST(BlurSegmentation, TwoBlursSideBySideAreToldApart) {
  const LineBlur left{15, 20 * kRadPerDeg}, right{22, 110 * kRadPerDeg};
  const cv::Mat image = TwoBlurs(left, right);
  const std::vector<BlurRegion> regions = SegmentBlur(image);
  ASSERT_EQ(regions.size(), 2u);
  ExpectCovers(regions, image.size());
  // The border between the regions lies in the middle of the image, to two sample cells of 10 px.
  EXPECT_NEAR(regions[1].rectangle.x, 320, 20);
  EXPECT_LT(regions[0].estimate.blur.DirectionError(left), 3 * kRadPerDeg);
  EXPECT_LT(regions[1].estimate.blur.DirectionError(right), 3 * kRadPerDeg);
  EXPECT_NEAR(regions[0].estimate.blur.extent_px, 15, 1.5);
  EXPECT_NEAR(regions[1].estimate.blur.extent_px, 22, 1.5);
}

TEST(BlurSegmentation, OneBlurIsOneRegion) {
  // The two least bins are neighbours, so both clusters start, and end, with the same blur: they are merged.
  const LineBlur truth{18, 65 * kRadPerDeg};
  const std::vector<BlurRegion> regions = SegmentBlur(TwoBlurs(truth, truth));
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_LT(regions[0].estimate.blur.DirectionError(truth), 3 * kRadPerDeg);
  EXPECT_NEAR(regions[0].estimate.blur.extent_px, 18, 1.5);
}

TEST(BlurSegmentation, AnyNumberOfClustersCoversTheImage) {
  const cv::Mat image = BlurPhotograph(Photograph("graf1.png"), {15, 0.3}, 2, 1);
  for (const int clusters : {1, 3, 6}) {
    BlurSegmentationOptions options;
    options.clusters = clusters;
    const std::vector<BlurRegion> regions = SegmentBlur(image, options);
    EXPECT_LE(int(regions.size()), clusters);
    ExpectCovers(regions, image.size());
  }
}

TEST(BlurSegmentation, StopsAtTheLimitOfIterations) {
  BlurSegmentationOptions options;
  options.max_iterations = 1;
  ExpectCovers(SegmentBlur(Photograph("home.jpg"), options), Photograph("home.jpg").size());
}

TEST(BlurSegmentation, AnEmptyImageIsOneSharpRegion) {
  const std::vector<BlurRegion> regions = SegmentBlur(cv::Mat(120, 160, CV_8UC1, cv::Scalar(77)));
  ExpectCovers(regions, {160, 120});
  for (const BlurRegion& region : regions) EXPECT_FALSE(region.estimate.blurred);
  ExpectCovers(SegmentBlur(cv::Mat(5, 5, CV_8UC1, cv::Scalar(77))), {5, 5});
}

TEST(BlurSegmentation, RefusesImpossibleOptions) {
  BlurSegmentationOptions options;
  options.clusters = 0;
  EXPECT_THROW(SegmentBlur(cv::Mat(50, 50, CV_8UC1, cv::Scalar(1)), options), BadOption);
}

}  // namespace
}  // namespace gaitcam
