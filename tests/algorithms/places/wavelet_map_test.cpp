#include "algorithms/places/wavelet_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "algorithms/core/errors.h"
#include "cylinder_world.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

const Eigen::Vector3d kUpC = UpOf(5);

PanoramaLayout MapLayout() { return LayoutFor(Ers7Camera(), kUpC, 720, 160); }

TEST(WaveletMap, KeepsAnErs7PanoramaIn169Bytes) {
  WaveletMap map;
  map.Add(WaveletEncoder(160).OfPanorama(CylinderWorld(1).Panorama(MapLayout())));
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
      const cv::Mat picture = CylinderWorld(3).Panorama(MapLayout());
      const cv::Mat view = cv::repeat(CylinderWorld(4).Panorama(MapLayout()), 1, 2).colRange(200, 200 + width);
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
  const PanoramaLayout layout = MapLayout();
  const CylinderProjection projection(Ers7Camera(), kUpC, layout);
  const WaveletEncoder encoder(160);
  std::vector<double> errors_px;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const CylinderWorld world(seed);
    WaveletMap map;
    map.Add(encoder.OfPanorama(world.Panorama(layout)));
    for (double yaw_deg = -180; yaw_deg < 180; yaw_deg += 9.3) {
      const double yaw = yaw_deg * std::numbers::pi / 180;
      const cv::Mat view = projection.ProjectView(world.View(Ers7Camera(), kUpC, yaw));
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

TEST(WaveletMap, LooksOnlyWhereAViewMayLie) {
  const PanoramaLayout layout = MapLayout();
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
std::string ErrorOfQuery(Function function) {
  try {
    function();
  } catch (const BadInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(WaveletMap, SaysInOneLineWhyAViewCannotBeCompared) {
  const WaveletEncoder encoder(160);
  const WaveletView view = encoder.OfView(cv::Mat(160, 208, CV_8UC1, cv::Scalar(0)));
  WaveletMap map;
  EXPECT_THAT(ErrorOfQuery([&] { map.Query(view); }), HasSubstr("empty"));
  map.Add(encoder.OfPanorama(cv::Mat(160, 160, CV_8UC1, cv::Scalar(0))));
  EXPECT_THAT(ErrorOfQuery([&] { map.Query(view); }), HasSubstr("narrower than the view"));
}

}  // namespace
}  // namespace gaitcam
