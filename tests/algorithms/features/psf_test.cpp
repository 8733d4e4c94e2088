#include "algorithms/features/psf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/features/psf_oracle.h"

namespace gaitcam {
namespace {

TEST(Psf, EveryListedEstimatorCanBeMade) {
  ASSERT_GE(ListPsfEstimators().size(), 2u);
  for (const PsfEstimatorInfo& info : ListPsfEstimators()) {
    const auto psf = MakePsfEstimator(info.name);
    ASSERT_NE(psf, nullptr) << info.name;
    EXPECT_FALSE(psf->EstimateWhole(cv::Mat(128, 128, CV_8UC1, cv::Scalar(0))).blurred) << info.name;
  }
}

TEST(Psf, UnknownNamesGetAHint) {
  try {
    MakePsfEstimator("spectrl");
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("did you mean spectral"));
  }
}

TEST(LineBlur, OppositeVectorsAreTheSameBlur) {
  const LineBlur a = LineBlur::FromVector({3, -4}), b = LineBlur::FromVector({-3, 4});
  EXPECT_DOUBLE_EQ(a.extent_px, 5);
  EXPECT_NEAR(a.DirectionError(b), 0, 1e-12);
  EXPECT_NEAR(LineBlur({1, 0.01}).DirectionError({1, M_PI - 0.01}), 0.02, 1e-12);
}

TEST(OraclePsf, SaysWhatItWasTold) {
  const BlurEstimate e = OraclePsf(LineBlur{12, 0.3}).EstimateWhole(cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)));
  EXPECT_EQ(e.blur.extent_px, 12);
  EXPECT_EQ(e.blur.direction_rad, 0.3);
  EXPECT_TRUE(e.blurred);
  EXPECT_FALSE(OraclePsf(LineBlur{1, 0.3}).EstimateWhole(cv::Mat(10, 10, CV_8UC1, cv::Scalar(0))).blurred);
}

TEST(OraclePsf, AveragesARegionWhateverTheSignsAndLeavesUnknownPixelsOut) {
  cv::Mat vectors(4, 4, CV_32FC2, cv::Scalar(3, 4));
  vectors.at<cv::Vec2f>(0, 0) = {-3, -4};
  vectors.at<cv::Vec2f>(1, 1) = cv::Vec2f::all(std::numeric_limits<float>::quiet_NaN());
  vectors.row(3).setTo(cv::Scalar(100, 0));
  const BlurEstimate e = OraclePsf(vectors).Estimate(cv::Mat(4, 4, CV_8UC1, cv::Scalar(0)), {0, 0, 4, 3});
  EXPECT_NEAR(e.blur.extent_px, 5, 1e-6);
  EXPECT_NEAR(e.blur.direction_rad, std::atan2(4, 3), 1e-6);
}

}  // namespace
}  // namespace gaitcam
