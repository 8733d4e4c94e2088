#include "algorithms/features/hessian_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// A Gaussian blob on mid grey: light = 0.5 + height exp(-r^2 / (2 s^2)).
cv::Mat Blob(const cv::Size& size, double x, double y, double s, double height) {
  cv::Mat image(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u)
      image.at<float>(v, u) = float(0.5 + height * std::exp(-((u - x) * (u - x) + (v - y) * (v - y)) / (2 * s * s)));
  return image;
}

/// The strongest point, in pixels of the image: x, y, scale.
Eigen::Vector3d Strongest(const cv::Mat& image, const ScaleSpaceOptions& scales, const HessianOptions& options) {
  const ScaleSpace space = BuildScaleSpace(image, scales);
  const std::vector<ScalePoint> points = DetectHessian(space, options);
  EXPECT_FALSE(points.empty());
  if (points.empty()) return Eigen::Vector3d::Zero();
  const ScalePoint& p = *std::max_element(
      points.begin(), points.end(), [](const ScalePoint& a, const ScalePoint& b) { return a.response < b.response; });
  const ScaleOctave& octave = space[size_t(p.octave)];
  return {octave.origin_px + octave.pitch_px * p.x, octave.origin_px + octave.pitch_px * p.y,
          octave.pitch_px * p.scale};
}

TEST(HessianDetector, FindsBlobsWhereTheyAreInPixelsWhoseFirstCentreIsZero) {
  ScaleSpaceOptions scales;
  scales.camera_sigma = 0;
  for (const bool doubled : {false, true}) {
    scales.first_doubled = doubled;
    for (const double s : {2.5, 5.0, 9.0}) {
      const Eigen::Vector3d p = Strongest(Blob({161, 120}, 77.3, 58.6, s, 0.3), scales, {});
      // The quadratic is not the true shape: a twenty-fifth of the pitch, 4 px, of the octave that sees the coarsest.
      EXPECT_NEAR(p.x(), 77.3, 0.16) << s << doubled;
      EXPECT_NEAR(p.y(), 58.6, 0.16) << s << doubled;
    }
  }
}

TEST(HessianDetector, CharacteristicScaleIsTheBlobsOwn) {
  // sigma^4 det H of a Gaussian blob of scale s peaks over sigma at sigma = s.
  ScaleSpaceOptions scales;
  scales.camera_sigma = 0;
  HessianOptions options;
  options.compact = true;  // equation 5.9's wide differences smooth further and see fine blobs coarser
  for (const double s : {2.5, 5.0, 9.0}) {
    const double found = Strongest(Blob({160, 120}, 80, 60, s, 0.3), scales, options).z();
    EXPECT_NEAR(found / s, 1, 0.06) << s;  // a fifth of the step between levels, 2^(1/3)
  }
}

TEST(HessianDetector, DeterminantOfAGaussianIsTheAnalyticOne) {
  const double s = 6;
  const cv::Mat image = Blob({61, 61}, 30, 30, s, 1);
  for (const bool compact : {false, true}) {
    const cv::Mat det = HessianDeterminant({1.0, image}, compact);
    const double expected = 1 / (s * s * s * s);                    // at the centre Lxx = Lyy = -1 / s^2
    EXPECT_NEAR(det.at<float>(30, 30), expected, 0.06 * expected);  // finite differences: (h / s)^2 / 4 at h = 2
  }
}

TEST(HessianDetector, KindsTellDarkBrightAndSaddle) {
  HessianOptions options;
  options.saddles = true;
  const auto kind_at_centre = [&](const cv::Mat& image) {
    for (const ScalePoint& p : DetectHessian(BuildScaleSpace(image, {}), options))
      if (p.octave == 0 && std::hypot(p.x - 40, p.y - 40) < 1) return p.kind;
    ADD_FAILURE() << "no point at the centre";
    return PointKind::kDark;
  };
  EXPECT_EQ(kind_at_centre(Blob({81, 81}, 40, 40, 2.5, 0.3)), PointKind::kBright);
  EXPECT_EQ(kind_at_centre(Blob({81, 81}, 40, 40, 2.5, -0.3)), PointKind::kDark);
  // An endless chessboard's corner looks the same at all scales; this one has a scale of its own.
  cv::Mat saddle(81, 81, CV_32FC1);
  for (int y = 0; y < 81; ++y)
    for (int x = 0; x < 81; ++x) {
      const double u = (x - 40) / 3.0, v = (y - 40) / 3.0;
      saddle.at<float>(y, x) = float(0.5 + 0.8 * u * v * std::exp(-(u * u + v * v) / 2));
    }
  EXPECT_EQ(kind_at_centre(saddle), PointKind::kSaddle);
}

TEST(HessianDetector, StraightEdgesGiveNoPoints) {
  cv::Mat edge(100, 100, CV_32FC1, cv::Scalar(0.2));
  edge.colRange(50, 100) = 0.8;
  HessianOptions options;
  options.saddles = true;
  EXPECT_THAT(DetectHessian(BuildScaleSpace(edge, {}), options), testing::IsEmpty());
}

TEST(HessianDetector, KeepsTheStrongestInsideTheRegion) {
  cv::Mat image = Blob({200, 100}, 50, 50, 3, 0.3) + Blob({200, 100}, 150, 50, 3, 0.2) - 0.5;
  HessianOptions options;
  const ScaleSpace space = BuildScaleSpace(image, {});
  EXPECT_EQ(DetectHessian(space, options).size(), 2u);
  const std::vector<ScalePoint> right = DetectHessian(space, options, cv::Rect(100, 0, 100, 100));
  ASSERT_EQ(right.size(), 1u);
  EXPECT_GT(right[0].x, 100);
  options.max_points = 1;
  const std::vector<ScalePoint> strongest = DetectHessian(space, options);
  ASSERT_EQ(strongest.size(), 1u);
  EXPECT_LT(strongest[0].x, 100);
}

TEST(HessianDetector, RefusesAThresholdOfZero) {
  HessianOptions options;
  options.threshold = 0;
  EXPECT_THROW(DetectHessian({}, options), BadOption);
}

}  // namespace
}  // namespace gaitcam
