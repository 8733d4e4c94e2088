#include "algorithms/features/descriptor_distance.h"

#include <gtest/gtest.h>

#include <numeric>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

TEST(DescriptorDistances, AreThoseOfOpenCvForEveryLengthAndNumberOfRows) {
  RandomStream random(1, "descriptors");
  for (const int length : {1, 4, 7, 8, 13, 64, 128, 131}) {
    cv::Mat rows(11, length, CV_32FC1);
    for (int i = 0; i < rows.rows; ++i) {
      for (int k = 0; k < length; ++k) rows.at<float>(i, k) = float(random.Uniform(0, 1));
    }
    for (int count = 0; count <= rows.rows; ++count) {
      std::vector<int> chosen(static_cast<size_t>(count));
      std::iota(chosen.rbegin(), chosen.rend(), 0);
      std::vector<float> distances = {7, 7};
      DescriptorDistances(rows.row(3), rows, chosen, distances);
      ASSERT_EQ(distances.size(), chosen.size());
      for (size_t i = 0; i < chosen.size(); ++i) {
        const double expected = cv::norm(rows.row(3), rows.row(chosen[i]), cv::NORM_L2);
        EXPECT_NEAR(distances[i], expected, 1e-6 * (1 + expected)) << length;  // sums of floats
        if (chosen[i] == 3) {
          EXPECT_EQ(distances[i], 0);
        }
      }
    }
  }
}

TEST(DescriptorDistances, DoNotDependOnWhatElseIsCompared) {
  RandomStream random(2, "descriptors");
  cv::Mat rows(9, 131, CV_32FC1);
  for (int i = 0; i < rows.rows; ++i) {
    for (int k = 0; k < rows.cols; ++k) rows.at<float>(i, k) = float(random.Uniform(0, 1));
  }
  std::vector<int> all(size_t(rows.rows));
  std::iota(all.begin(), all.end(), 0);
  std::vector<float> together, alone;
  DescriptorDistances(rows.row(0), rows, all, together);
  for (const int i : all) {
    DescriptorDistances(rows.row(0), rows, {i}, alone);
    EXPECT_EQ(alone[0], together[size_t(i)]);
  }
}

TEST(DescriptorDistances, OfBitsCountThoseThatDiffer) {
  const cv::Mat rows = (cv::Mat_<uchar>(3, 2) << 0, 0, 1, 3, 255, 255);
  std::vector<float> distances;
  DescriptorDistances(rows.row(0), rows, {2, 1, 0}, distances);
  EXPECT_EQ(distances, (std::vector<float>{16, 3, 0}));
}

}  // namespace
}  // namespace gaitcam
