#include "algorithms/io/covariance_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/algorithms/io/file_test.h"

namespace gaitcam {
namespace {

class CovarianceFile : public FileTest {};

Matrix6d SomeCovariance(double scale) {
  Matrix6d root = Matrix6d::Zero();
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col <= row; ++col) root(row, col) = scale * (row == col ? 1.0 : 0.1 * row - 0.03 * col);
  }
  Matrix6d covariance = root * root.transpose();
  return 0.5 * (covariance + covariance.transpose().eval());
}

TEST_F(CovarianceFile, ComesBackToTheBitForTheFramesThatHaveOne) {
  std::vector<FrameEstimate> frames(3);
  for (size_t i = 0; i < 3; ++i) frames[i].stamp_ns = int64_t(i) * 33'333'333 + 5;
  frames[0].covariance = SomeCovariance(1e-3);
  frames[2].covariance = SomeCovariance(0.7);
  ASSERT_TRUE(WriteCovariances(folder_ / "covariances.csv", frames));
  const std::vector<StampedCovariance> read = ReadCovariances(folder_ / "covariances.csv");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].stamp_ns, frames[0].stamp_ns);
  EXPECT_EQ(read[0].covariance, *frames[0].covariance);
  EXPECT_EQ(read[1].stamp_ns, frames[2].stamp_ns);
  EXPECT_EQ(read[1].covariance, *frames[2].covariance);
}

TEST_F(CovarianceFile, SaysWhatIsAFramesOwnWhereItIsKnown) {
  std::vector<FrameEstimate> frames(2);
  frames[1].stamp_ns = 7;
  frames[0].covariance = frames[1].covariance = SomeCovariance(1);
  frames[1].own_covariance = SomeCovariance(0.1);
  frames[1].common_errors = CommonErrors::Random(6, 2);
  ASSERT_TRUE(WriteCovariances(folder_ / "covariances.csv", frames));
  const std::vector<StampedCovariance> read = ReadCovariances(folder_ / "covariances.csv");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_FALSE(read[0].own_covariance);
  ASSERT_TRUE(read[1].own_covariance);
  EXPECT_EQ(*read[1].own_covariance, *frames[1].own_covariance);
  EXPECT_EQ(read[1].common_errors, frames[1].common_errors);
}

TEST_F(CovarianceFile, IsNotWrittenWhereNoFrameHasOne) {
  EXPECT_FALSE(WriteCovariances(folder_ / "covariances.csv", std::vector<FrameEstimate>(4)));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "covariances.csv"));
}

TEST_F(CovarianceFile, SaysWhereItIsWrong) {
  const auto error = [&](const std::string& text) -> std::string {
    try {
      ReadCovariances(Write("bad.csv", text));
    } catch (const BadInput& e) {
      return e.what();
    }
    return "nothing was thrown";
  };
  std::string row;
  for (int i = 0; i < 21; ++i) row += ",1";
  EXPECT_THAT(error("5" + row + "\n5" + row + "\n"), testing::HasSubstr("bad.csv:2: its time does not come after"));
  EXPECT_THAT(error("5,1,2\n"), testing::HasSubstr("bad.csv:1: the row ends after 3 fields"));
}

TEST(CovarianceFileName, FollowsTheTrajectorys) {
  EXPECT_EQ(CovarianceFileOf("out/estimate.txt"), "out/covariances.csv");
  EXPECT_EQ(CovarianceFileOf("estimate-sift_vo.txt"), "covariances-sift_vo.csv");
  EXPECT_EQ(CovarianceFileOf("a/mine.txt"), "a/mine-covariances.csv");
}

}  // namespace
}  // namespace gaitcam
