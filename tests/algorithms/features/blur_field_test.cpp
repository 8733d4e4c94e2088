#include "algorithms/features/blur_field.h"

#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "algorithms/features/blur_segmentation.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {
namespace {

using psf_test::BlurredByTurn;
using psf_test::Photograph;

constexpr double kFocal = 277;  // 60 degrees over 320 px
const cv::Size kSize(320, 240);

template <class VectorAt>
double MedianError(const cv::Mat& truth, VectorAt&& vector_at) {
  std::vector<double> errors;
  for (int y = 4; y < truth.rows; y += 8) {
    for (int x = 4; x < truth.cols; x += 8)
      errors.push_back(BlurVectorError(vector_at(x, y), truth.at<cv::Vec2f>(y, x)));
  }
  return UpperMedian(errors);
}

Eigen::Vector2d RegionVector(const std::vector<BlurRegion>& regions, int x, int y) {
  for (const BlurRegion& r : regions) {
    if (r.rectangle.contains({x, y})) return r.estimate.blur.Vector();
  }
  return Eigen::Vector2d::Zero();
}

TEST(BlurField, FollowsATurnWithRollBetterThanClusters) {
  BlurFieldOptions options;
  options.focal_px = kFocal;
  std::vector<double> field_errors, region_errors, cluster_errors;
  for (const std::string& name : psf_test::PhotographNames()) {
    cv::Mat truth;
    const cv::Mat image = BlurredByTurn(Photograph(name), kSize, kFocal, {0.03, -0.04, 0.05}, 1, 1, truth);
    const BlurField field = EstimateBlurField(image, options);
    field_errors.push_back(MedianError(truth, [&](int x, int y) { return field.VectorAt({x, y}); }));
    const std::vector<BlurRegion> regions = DivideByBlur(field, image.size(), options);
    region_errors.push_back(MedianError(truth, [&](int x, int y) { return RegionVector(regions, x, y); }));
    const std::vector<BlurRegion> clusters = SegmentBlur(image);
    cluster_errors.push_back(MedianError(truth, [&](int x, int y) { return RegionVector(clusters, x, y); }));
  }
  // Blur is 14 px in the middle and 5 to 24 px at the corners.
  EXPECT_LT(UpperMedian(field_errors), 0.6);
  EXPECT_LT(UpperMedian(region_errors), 2);  // the tolerance of a region
  EXPECT_GT(UpperMedian(cluster_errors), 3 * UpperMedian(region_errors));
}

TEST(BlurField, VectorsAreThoseOfASmallTurn) {
  cv::Mat truth;
  const cv::Vec3d turn(0.004, -0.003, 0.005);
  BlurredByTurn(Photograph("graf1.png"), kSize, kFocal, turn, 0, 1, truth);
  BlurField field;
  field.centre = {159.5, 119.5};
  field.focal_px = kFocal;
  // A camera that turns by t sees points turn by -t: b = -f (-t_y, t_x) in the fixture's terms.
  field.at_centre = {-kFocal * turn[1], kFocal * turn[0]};
  field.roll_rad = turn[2];
  double worst = 0;
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(319, 10), std::pair(160, 120), std::pair(40, 239)}) {
    worst = std::max(worst, BlurVectorError(field.VectorAt({x, y}), truth.at<cv::Vec2f>(y, x)));
  }
  EXPECT_LT(worst, 0.01);  // third order in the angle
}

TEST(BlurField, RegionsCoverTheImageAndVaryLittle) {
  BlurField field;
  field.centre = {159.5, 119.5};
  field.at_centre = {12, 3};
  field.roll_rad = 0.06;
  field.confidence = 1;
  const BlurFieldOptions options;
  const std::vector<BlurRegion> regions = DivideByBlur(field, kSize, options);
  EXPECT_GT(regions.size(), 3u);
  cv::Mat count(kSize, CV_8UC1, cv::Scalar(0));
  for (const BlurRegion& r : regions) {
    count(r.rectangle) += 1;
    EXPECT_GE(std::min(r.rectangle.width, r.rectangle.height), options.min_region_px / 2);
  }
  EXPECT_EQ(cv::countNonZero(count == 1), kSize.area());
}

TEST(BlurField, AUniformBlurIsOneRegion) {
  cv::Mat truth;
  const cv::Mat image = BlurPhotograph(Photograph("graf1.png"), {16, 0.7}, 1, 1, false, kSize);
  const std::vector<BlurRegion> regions = SegmentBlurField(image);
  ASSERT_LE(regions.size(), 2u);
  for (const BlurRegion& r : regions) {
    EXPECT_TRUE(r.estimate.blurred);
    EXPECT_NEAR(r.estimate.blur.extent_px, 16, 1.5);
  }
}

TEST(BlurField, EmptyAndSmallImagesHaveNone) {
  EXPECT_EQ(EstimateBlurField(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0))).confidence, 0);
  EXPECT_EQ(EstimateBlurField(cv::Mat(64, 64, CV_8UC1, cv::Scalar(0))).confidence, 0);
}

TEST(BlurField, RefusesImpossibleOptions) {
  BlurFieldOptions options;
  options.tile_px = 100;
  EXPECT_THROW(EstimateBlurField(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)), options), BadOption);
}

}  // namespace
}  // namespace gaitcam
