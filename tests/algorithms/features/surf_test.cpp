#include "algorithms/features/surf.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace gaitcam {
namespace {

// A Gaussian blob, black on white, centred anywhere.
cv::Mat Blob(double x, double y, double sigma) {
  cv::Mat image(200, 240, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<uchar>(v, u) =
          uchar(220 - 180 * std::exp(-((u - x) * (u - x) + (v - y) * (v - y)) / (2 * sigma * sigma)));
    }
  }
  return image;
}

TEST(Surf, FindsABlobWhereItIs) {
  for (const double sigma : {4.0, 6.0}) {
    const double x = 120.3, y = 97.8;
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    Surf::create()->detectAndCompute(Blob(x, y, sigma), cv::noArray(), keypoints, descriptors, false);
    ASSERT_FALSE(keypoints.empty());
    ASSERT_EQ(descriptors.rows, int(keypoints.size()));
    EXPECT_NEAR(cv::norm(descriptors.row(0)), 1, 1e-5);
    // dlib samples its box filters every second pixel and interpolates: half a pixel.
    EXPECT_NEAR(keypoints[0].pt.x, x, 0.5);
    EXPECT_NEAR(keypoints[0].pt.y, y, 0.5);
  }
}

TEST(Surf, DescribesGivenPointsAsItsOwnAndDropsThoseAtTheEdge) {
  cv::Mat image = Blob(120, 100, 6);
  cv::rectangle(image, {70, 60, 40, 30}, cv::Scalar(30), cv::FILLED);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat own, again;
  const auto surf = Surf::create();
  surf->detectAndCompute(image, cv::noArray(), keypoints, own, false);
  ASSERT_GT(keypoints.size(), 1u);
  std::vector<cv::KeyPoint> given = keypoints;
  given.insert(given.begin(), cv::KeyPoint(1, 1, 8, 0));
  surf->detectAndCompute(image, cv::noArray(), given, again, true);
  ASSERT_EQ(given.size(), keypoints.size());
  EXPECT_LT(cv::norm(own, again, cv::NORM_INF), 1e-2);  // angles went through degrees and floats
}

}  // namespace
}  // namespace gaitcam
