#include "sim/camera/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gaitcam {
namespace {

cv::Mat Flat(int value, int width = 4, int height = 3) {
  return cv::Mat(height, width, CV_8UC4, cv::Scalar(value, value, value, 255));
}

TEST(Light, EveryDisplayValueSurvivesDecodingAndEncoding) {
  for (int value = 0; value < 256; ++value) {
    LightAccumulator light(4, 3);
    for (int i = 0; i < 7; ++i) light.Add(Flat(value), 1.f / 7);
    EXPECT_EQ(EncodeSrgb(light.light()).at<cv::Vec3b>(1, 2), cv::Vec3b::all(uint8_t(value))) << value;
  }
}

TEST(Light, HalfWhiteAndHalfBlackIsDisplayed188) {
  LightAccumulator light(4, 3);
  light.Add(Flat(255), 0.5f);
  light.Add(Flat(0), 0.5f);
  // 255 (1.055 0.5^(1/2.4) - 0.055) = 187.5; averaging display values would give 128.
  EXPECT_NEAR(EncodeSrgb(light.light()).at<cv::Vec3b>(0, 0)[0], 187.5, 0.5);
}

TEST(Light, TheFirstRowReadIsTheBottomOfTheImage) {
  cv::Mat picture = Flat(0);
  picture.row(0).setTo(cv::Scalar::all(255));
  LightAccumulator light(4, 3);
  light.Add(picture, 1);
  EXPECT_EQ(light.light().at<cv::Vec3f>(2, 0), cv::Vec3f::all(1));
  EXPECT_EQ(light.light().at<cv::Vec3f>(0, 0), cv::Vec3f::all(0));
}

TEST(Light, RowsHaveTheirOwnWeights) {
  LightAccumulator light(4, 3);
  const float weights[] = {0.25f, 0.f, 1.f};
  light.Add(Flat(255), weights);
  for (int row = 0; row < 3; ++row) EXPECT_EQ(light.light().at<cv::Vec3f>(row, 1)[2], weights[row]);
}

TEST(Light, ABentPictureIsSampledWhereTheMapSaysLessItsShift) {
  // A picture whose light grows linearly with x and y would be exact under bilinear sampling; display values are 8 bit,
  // so use light 0 and 1 only: a step between columns 3 and 4.
  cv::Mat picture(8, 8, CV_8UC4, cv::Scalar::all(0));
  picture.colRange(4, 8).setTo(cv::Scalar::all(255));
  cv::Mat map(1, 1, CV_32FC2, cv::Scalar(3.75, 3.0));
  LightAccumulator straight(1, 1), shifted(1, 1);
  const float weight[] = {1};
  straight.AddBent(picture, map, {0, 0}, weight);
  shifted.AddBent(picture, map, {0.5, 0.25}, weight);
  EXPECT_FLOAT_EQ(straight.light().at<cv::Vec3f>(0, 0)[0], 0.75f);
  EXPECT_FLOAT_EQ(shifted.light().at<cv::Vec3f>(0, 0)[0], 0.25f);
}

TEST(PixelShifts, AreStratifiedAndOfMeanZero) {
  for (const int count : {1, 2, 4, 7, 16, 50}) {
    const std::vector<Eigen::Vector2d> shifts = PixelShifts(count);
    Eigen::Vector2d mean(0, 0);
    std::vector<int> columns(count, 0), rows(count, 0);
    for (const Eigen::Vector2d& shift : shifts) {
      mean += shift / count;
      ++columns.at(size_t((shift.x() + 0.5) * count));
      ++rows.at(size_t((shift.y() + 0.5) * count));
    }
    EXPECT_NEAR(mean.norm(), 0, 1e-12);
    EXPECT_EQ(columns, std::vector<int>(count, 1));
    EXPECT_EQ(rows, std::vector<int>(count, 1));
  }
}

}  // namespace
}  // namespace gaitcam
