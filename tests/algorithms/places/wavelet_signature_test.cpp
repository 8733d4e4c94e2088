#include "algorithms/places/wavelet_signature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cylinder_world.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

const Eigen::Vector3d kUp = UpOf(5);

PanoramaLayout Ers7Layout() { return LayoutFor(Ers7Camera(), kUp, 720, 160); }

/// Level 4 of the 2-D Haar transform by its definition: pairs of columns, then of rows, four times over.
struct Haar {
  cv::Mat approximation, h, v, d;

  static Haar Of(cv::Mat image, int levels) {
    Haar haar;
    for (int level = 0; level < levels; ++level) {
      haar.approximation = cv::Mat(image.rows / 2, image.cols / 2, CV_64F);
      haar.h = haar.approximation.clone(), haar.v = haar.approximation.clone(), haar.d = haar.approximation.clone();
      for (int y = 0; y < image.rows / 2; ++y) {
        for (int x = 0; x < image.cols / 2; ++x) {
          const double a = image.at<double>(2 * y, 2 * x), b = image.at<double>(2 * y, 2 * x + 1);
          const double c = image.at<double>(2 * y + 1, 2 * x), e = image.at<double>(2 * y + 1, 2 * x + 1);
          haar.approximation.at<double>(y, x) = (a + b + c + e) / 2;
          haar.h.at<double>(y, x) = (a + b - c - e) / 2;
          haar.v.at<double>(y, x) = (a - b + c - e) / 2;
          haar.d.at<double>(y, x) = (a - b - c + e) / 2;
        }
      }
      image = haar.approximation;
    }
    return haar;
  }
};

TEST(WaveletSignature, IsTheSignsOfTheHaarTransformOfTheSmoothedPanorama) {
  int bits = 0, wrong = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    WaveletOptions options;
    options.prefilter = seed % 2 ? 1 : 0.5;  // the thesis's, and ours
    const double sigma = 16 * options.prefilter;
    const cv::Mat panorama = CylinderWorld(seed).Panorama(Ers7Layout());
    const WaveletSignature signature = WaveletEncoder(160, options).OfPanorama(panorama);
    cv::Mat smooth, wide;
    panorama.convertTo(smooth, CV_64F);
    cv::hconcat(std::vector<cv::Mat>{smooth, smooth, smooth}, wide);
    cv::GaussianBlur(wide, wide, {129, 129}, sigma, sigma, cv::BORDER_REPLICATE);
    const Haar haar = Haar::Of(wide.colRange(720, 1440), 4);
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 45; ++x) {
        wrong += signature.Bit(WaveletSignature::kHorizontal, y, x) != (haar.h.at<double>(y, x) >= 0);
        wrong += signature.Bit(WaveletSignature::kVertical, y, x) != (haar.v.at<double>(y, x) >= 0);
        wrong += signature.Bit(WaveletSignature::kDiagonal, y, x) != (haar.d.at<double>(y, x) >= 0);
        bits += 3;
      }
    }
  }
  EXPECT_LT(wrong, 0.01 * bits) << wrong << " of " << bits;  // as its header claims
}

TEST(WaveletSignature, OfAnErs7PanoramaTakes169Bytes) {
  const WaveletSignature signature = WaveletEncoder(160).OfPanorama(CylinderWorld(1).Panorama(Ers7Layout()));
  EXPECT_EQ(signature.columns(), 45);
  EXPECT_EQ(signature.rows(), 10);
  EXPECT_EQ(signature.bytes(), 169u);
}

TEST(WaveletSignature, DoesNotChangeWithGainAndOffsetOfTheLight) {
  cv::Mat panorama = CylinderWorld(7).Panorama(Ers7Layout()) / 4 + 5, brighter = 2 * panorama + 30;
  const WaveletEncoder encoder(160);
  EXPECT_EQ(encoder.OfPanorama(panorama), encoder.OfPanorama(brighter));
  const cv::Mat view = panorama.colRange(100, 308), bright_view = brighter.colRange(100, 308);
  EXPECT_EQ(encoder.OfView(view).shifts, encoder.OfView(bright_view).shifts);
}

TEST(WaveletSignature, OfABlankWallIsThatOfNoDetail) {
  const WaveletSignature signature = WaveletEncoder(160).OfPanorama(cv::Mat(160, 720, CV_8UC1, cv::Scalar(173)));
  for (int bit = 0; bit < 1350; ++bit) EXPECT_TRUE(signature.words()[size_t(bit) / 64] >> (bit % 64) & 1);
}

TEST(WaveletSignature, OfATurnedPanoramaIsTurned) {
  const cv::Mat panorama = CylinderWorld(2).Panorama(Ers7Layout());
  cv::Mat turned;
  cv::hconcat(panorama.colRange(160, 720), panorama.colRange(0, 160), turned);
  const WaveletSignature a = WaveletEncoder(160).OfPanorama(panorama), b = WaveletEncoder(160).OfPanorama(turned);
  for (int column = 0; column < 45; ++column) {
    for (int row = 0; row < 10; ++row) {
      EXPECT_EQ(a.Bit(WaveletSignature::kVertical, row, (column + 10) % 45),
                b.Bit(WaveletSignature::kVertical, row, column));
    }
  }
}

TEST(WaveletView, ShiftsMoveByTwoPixelsEach) {
  // Far from the borders, the picture without its first 16 - 2 = 14 pixels, and 2 more, has the same squares one column
  // on.
  const cv::Mat panorama = CylinderWorld(9).Panorama(Ers7Layout());
  const WaveletEncoder encoder(160);
  const WaveletView view = encoder.OfView(panorama.colRange(100, 500)),
                    later = encoder.OfView(panorama.colRange(114, 500));
  for (int column = 5; column < 15; ++column) {
    for (int row = 0; row < 10; ++row) {
      EXPECT_EQ(view.shifts[7].Bit(WaveletSignature::kVertical, row, column),
                later.shifts[0].Bit(WaveletSignature::kVertical, row, column));
    }
  }
}

TEST(WaveletSignature, SaysWhatIsWrongInOneLine) {
  EXPECT_THAT(ErrorOf([] { WaveletEncoder(15); }), HasSubstr("15 px high is too small for level 4"));
  const WaveletEncoder encoder(160);
  EXPECT_THAT(ErrorOf([&] { encoder.OfView(cv::Mat(160, 29, CV_8UC1)); }), HasSubstr("29 px wide is too small"));
  EXPECT_THAT(ErrorOf([&] { encoder.OfPanorama(cv::Mat(160, 15, CV_8UC1)); }), HasSubstr("too small for level 4"));
  EXPECT_THAT(ErrorOf([&] { encoder.OfPanorama(cv::Mat(100, 720, CV_8UC1)); }), HasSubstr("160 px are expected"));
  WaveletOptions options;
  options.level = 9;
  EXPECT_THAT(ErrorOf([&] { WaveletEncoder(160, options); }), HasSubstr("wavelet.level: 9 is not permitted"));
}

}  // namespace
}  // namespace gaitcam
