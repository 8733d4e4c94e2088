#include "algorithms/places/wavelet_signature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cylinder_world.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

const Eigen::Vector3d kUp = UpOf(5);

PanoramaLayout Layout() { return LayoutFor(Ers7Camera(), kUp, 720, 160); }

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
    const cv::Mat panorama = CylinderWorld(seed).Panorama(Layout());
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
  const WaveletSignature signature = WaveletEncoder(160).OfPanorama(CylinderWorld(1).Panorama(Layout()));
  EXPECT_EQ(signature.columns(), 45);
  EXPECT_EQ(signature.rows(), 10);
  EXPECT_EQ(signature.bytes(), 169u);
  WaveletMap map;
  map.Add(signature);
  EXPECT_EQ(map.bytes_per_place(), 169u);
}

/// Eq. 4.4 term by term over windows that begin at every column, Sim's maximum over all of them and the 8 shifts.
double LeastDissimilarity(const WaveletView& view, const WaveletSignature& panorama, const WaveletOptions& options) {
  double least = 1e300;
  for (const WaveletSignature& shift : view.shifts) {
    for (int begin = 0; begin < panorama.columns(); ++begin) {
      double sum = 0;
      const auto add = [&](WaveletSignature::Band band, double weight) {
        for (int column = 0; column < shift.columns(); ++column) {
          for (int row = 0; row < shift.rows(); ++row) {
            const int a = shift.Bit(band, row, column) ? 1 : -1;
            const int b = panorama.Bit(band, row, (begin + column) % panorama.columns()) ? 1 : -1;
            sum += weight * std::abs(a - b);
          }
        }
      };
      add(WaveletSignature::kHorizontal, options.weight_h);
      add(WaveletSignature::kVertical, options.weight_v);
      add(WaveletSignature::kDiagonal, options.weight_d);
      least = std::min(least, sum);
    }
  }
  return least;
}

TEST(WaveletMap, CountsByWordsWhatEquation44SumsTermByTerm) {
  WaveletOptions uneven;
  uneven.weight_h = 0.3, uneven.weight_v = 0.45, uneven.weight_d = 0.25;
  for (const WaveletOptions& options : {WaveletOptions(), uneven}) {
    for (const int width : {30, 114, 208, 720}) {
      const cv::Mat picture = CylinderWorld(3).Panorama(Layout());
      const cv::Mat view = cv::repeat(CylinderWorld(4).Panorama(Layout()), 1, 2).colRange(200, 200 + width);
      const WaveletEncoder encoder(160, options);
      WaveletMap map(options);
      map.Add(encoder.OfPanorama(picture));
      const WaveletView encoded = encoder.OfView(view);
      const int columns = encoded.shifts[0].columns();
      EXPECT_EQ(columns, (width - 14) / 16);
      const double most = 2 * 10 * columns * (options.weight_h + options.weight_v + options.weight_d);
      EXPECT_NEAR(map.Query(encoded)[0].disagreement * most,
                  LeastDissimilarity(encoded, encoder.OfPanorama(picture), options), 1e-9);
    }
  }
}

TEST(WaveletMap, FindsTheBearingOfAViewAlsoRoundThePanoramasSeam) {
  const PanoramaLayout layout = Layout();
  const CylinderProjection projection(Ers7Camera(), kUp, layout);
  const WaveletEncoder encoder(160);
  std::vector<double> errors_px;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const CylinderWorld world(seed);
    WaveletMap map;
    map.Add(encoder.OfPanorama(world.Panorama(layout)));
    for (double yaw_deg = -180; yaw_deg < 180; yaw_deg += 9.3) {
      const double yaw = yaw_deg * std::numbers::pi / 180;
      const cv::Mat view = projection.ProjectView(world.View(Ers7Camera(), kUp, yaw));
      const WaveletMatch match = map.Query(encoder.OfView(view))[0];
      const double error = match.left_px + 0.5 * (view.cols - 1) - layout.ColumnOf(yaw);
      errors_px.push_back(std::abs(error - 720 * std::round(error / 720)));
    }
  }
  // 180 bits of squares of 16 px tell a shift of 2 px, but for a view here and there by the few bits at its borders.
  std::sort(errors_px.begin(), errors_px.end());
  EXPECT_LE(errors_px[errors_px.size() / 2], 1.0);
  EXPECT_LE(errors_px[errors_px.size() * 8 / 10], 2.0);
  EXPECT_LE(errors_px.back(), 8.0);
}

TEST(WaveletSignature, DoesNotChangeWithGainAndOffsetOfTheLight) {
  cv::Mat panorama = CylinderWorld(7).Panorama(Layout()) / 4 + 5, brighter = 2 * panorama + 30;
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
  const cv::Mat panorama = CylinderWorld(2).Panorama(Layout());
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
  const cv::Mat panorama = CylinderWorld(9).Panorama(Layout());
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

TEST(WaveletMap, LooksOnlyWhereAViewMayLie) {
  const PanoramaLayout layout = Layout();
  const cv::Mat once = CylinderWorld(3).Panorama(layout), twice = cv::repeat(once.colRange(0, 352), 1, 2);
  cv::Mat panorama = once.clone();
  twice.copyTo(panorama.colRange(0, 704));  // everything is there twice, 352 px apart
  const WaveletEncoder encoder(160);
  WaveletMap map;
  map.Add(encoder.OfPanorama(panorama));
  const WaveletView view = encoder.OfView(panorama.colRange(100, 220));
  EXPECT_NEAR(map.Query(view, 0, WaveletWindow{110, 30}).left_px, 100, 2);
  EXPECT_NEAR(map.Query(view, 0, WaveletWindow{440, 30}).left_px, 452, 2);
  EXPECT_NEAR(map.Query(view, 0, WaveletWindow{440 - 720, 30}).left_px, 452, 2);
  EXPECT_GT(map.Query(view, 0, WaveletWindow{250, 30}).disagreement, 0.2);
  EXPECT_LT(map.Query(view, 0, WaveletWindow{250, 1000}).disagreement, 0.1);
}

TEST(WaveletMap, SimilarityIsOneForACoinTossAndFiniteForTheSame) {
  EXPECT_DOUBLE_EQ(SimilarityOf(0.5, 210), 1);
  EXPECT_DOUBLE_EQ(SimilarityOf(0.25, 210), 2);
  EXPECT_DOUBLE_EQ(SimilarityOf(0, 210), 210);
}

template <class Function>
std::string ErrorOf(Function function) {
  try {
    function();
  } catch (const BadInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(WaveletSignature, SaysWhatIsWrongInOneLine) {
  EXPECT_THAT(ErrorOf([] { WaveletEncoder(15); }), HasSubstr("15 px high is too small for level 4"));
  const WaveletEncoder encoder(160);
  EXPECT_THAT(ErrorOf([&] { encoder.OfView(cv::Mat(160, 29, CV_8UC1)); }), HasSubstr("29 px wide is too small"));
  EXPECT_THAT(ErrorOf([&] { encoder.OfPanorama(cv::Mat(160, 15, CV_8UC1)); }), HasSubstr("too small for level 4"));
  EXPECT_THAT(ErrorOf([&] { encoder.OfPanorama(cv::Mat(100, 720, CV_8UC1)); }), HasSubstr("160 px are expected"));
  const WaveletView view = encoder.OfView(cv::Mat(160, 208, CV_8UC1, cv::Scalar(0)));
  WaveletMap map;
  EXPECT_THAT(ErrorOf([&] { map.Query(view); }), HasSubstr("empty"));
  map.Add(encoder.OfPanorama(cv::Mat(160, 160, CV_8UC1, cv::Scalar(0))));
  EXPECT_THAT(ErrorOf([&] { map.Query(view); }), HasSubstr("narrower than the view"));
  WaveletOptions options;
  options.level = 9;
  EXPECT_THAT(ErrorOf([&] { WaveletEncoder(160, options); }), HasSubstr("wavelet.level: 9 is not permitted"));
}

}  // namespace
}  // namespace gaitcam
