#include "algorithms/places/place_recognition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "algorithms/places/fourier_signature.h"
#include "cylinder_world.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
constexpr int kPlaces = 6;

struct Setting {
  PlaceIndexSetup setup;
  std::vector<CylinderWorld> worlds;

  Setting() {
    setup.layout = LayoutFor(Ers7Camera(), UpOf(3), 720, 160);
    setup.view_width_px = CylinderProjection(Ers7Camera(), UpOf(3), setup.layout).width_px();
    for (uint64_t seed = 1; seed <= kPlaces; ++seed) worlds.emplace_back(seed);
    for (uint64_t seed = 101; seed <= 104; ++seed) setup.training.push_back(CylinderWorld(seed).Panorama(setup.layout));
  }
};

const Setting& TheSetting() {
  static const Setting setting;
  return setting;
}

struct Counts {
  int right = 0, bearings = 0, all = 0;
};

Counts Recognise(const std::string& method) {
  const Setting& s = TheSetting();
  const auto index = MakePlaceIndex(method, s.setup);
  for (const CylinderWorld& world : s.worlds) index->Add(world.Panorama(s.setup.layout));
  EXPECT_EQ(index->size(), size_t(kPlaces));
  EXPECT_GT(index->bytes_per_place(), 0);
  const CylinderProjection projection(Ers7Camera(), UpOf(3), s.setup.layout);
  Counts counts;
  for (size_t place = 0; place < kPlaces; ++place) {
    for (double yaw = -3; yaw < 3; yaw += 0.8, ++counts.all) {
      const auto matches = index->Query(projection.ProjectView(s.worlds[place].View(Ers7Camera(), UpOf(3), yaw)));
      EXPECT_EQ(matches.size(), size_t(kPlaces));
      size_t best = 0;
      for (size_t k = 0; k < matches.size(); ++k) {
        EXPECT_GE(matches[k].similarity, 0);
        if (matches[k].similarity > matches[best].similarity) best = k;
      }
      const double error = std::remainder(matches[place].bearing_rad - yaw, 2 * std::numbers::pi);
      counts.right += best == place;
      counts.bearings += std::abs(error) < 8 * std::numbers::pi / 180;
    }
  }
  return counts;
}

// Views from the very places, in a world of flat rectangles: what a method cannot do here it cannot do at all.

TEST(PlaceIndex, WaveletsKnowEveryView) {
  const Counts counts = Recognise("wavelet");
  EXPECT_EQ(counts.right, counts.all);
  EXPECT_EQ(counts.bearings, counts.all);
}

TEST(PlaceIndex, ThumbnailsKnowEveryView) {
  const Counts counts = Recognise("thumbnail");
  EXPECT_EQ(counts.right, counts.all);
  EXPECT_EQ(counts.bearings, counts.all);
}

TEST(PlaceIndex, SpectraOfWindowsKnowMoreThanHalf) {
  const Counts counts = Recognise("fourier");
  EXPECT_GT(counts.right, counts.all / 2);
  EXPECT_GT(counts.bearings, counts.all / 2);
}

TEST(PlaceIndex, SpectraOfTheWholeAreHardlyBetterThanChance) {
  const Counts counts = Recognise("fourier_whole");
  EXPECT_LT(counts.right, counts.all / 2);  // why the thesis wants signatures that know where
}

TEST(PlaceIndex, WordsKnowMostViews) {
  const Counts counts = Recognise("orb_words");
  EXPECT_GT(counts.right, counts.all * 3 / 4);
  EXPECT_GT(counts.bearings, counts.all / 2);
}

TEST(FourierSignature, DoesNotChangeAsAPanoramaTurnsOrItsLightChanges) {
  const cv::Mat panorama = CylinderWorld(5).Panorama(TheSetting().setup.layout) / 2;
  cv::Mat turned;
  cv::hconcat(panorama.colRange(333, 720), panorama.colRange(0, 333), turned);
  turned = 1.5 * turned + 20;
  EXPECT_LT(FourierDistance(FourierSignature(panorama), FourierSignature(turned)), 0.2);  // rounding to 8 bit
  const cv::Mat other = CylinderWorld(6).Panorama(TheSetting().setup.layout);
  EXPECT_GT(FourierDistance(FourierSignature(panorama), FourierSignature(other)), 0.5);
}

TEST(FourierSignature, OfACosineIsOneCoefficient) {
  cv::Mat image(8, 240, CV_8UC1);
  for (int x = 0; x < 240; ++x)
    image.col(x).setTo(cv::saturate_cast<uchar>(128 + 100 * std::cos(2 * std::numbers::pi * 4 * x / 240)));
  const std::vector<float> signature = FourierSignature(image);
  // The row has unit variance: sum over both halves of |F|^2 / n is n, so |F_4| / sqrt(n) = sqrt(n / 2).
  EXPECT_NEAR(signature[3], std::sqrt(120.0), 0.05);
  for (size_t k = 0; k < signature.size(); ++k) {
    if (k == 3) continue;
    EXPECT_LT(signature[k], 0.1);
  }
}

TEST(PlaceIndex, SaysWhatIsWrongInOneLine) {
  PlaceIndexSetup setup = TheSetting().setup;
  EXPECT_THAT(ErrorOf([&] { MakePlaceIndex("wavelets", setup); }), HasSubstr("did you mean wavelet?"));
  const cv::Mat view(160, setup.view_width_px, CV_8UC1, cv::Scalar(0));
  for (const std::string& name : PlaceIndexNames()) {
    const auto index = MakePlaceIndex(name, setup);
    EXPECT_THAT(ErrorOf([&] { index->Query(view); }), HasSubstr("empty")) << name;
    EXPECT_THAT(ErrorOf([&] { index->Query(view.colRange(0, 50)); }), HasSubstr("50 x 160 px")) << name;
    EXPECT_THAT(ErrorOf([&] { index->Add(view); }), HasSubstr("720 x 160 px are expected")) << name;
  }
  setup.training.clear();
  EXPECT_THAT(ErrorOf([&] { MakePlaceIndex("orb_words", setup); }), HasSubstr("learn its words"));
  setup.view_width_px = 721;
  EXPECT_THAT(ErrorOf([&] { MakePlaceIndex("wavelet", setup); }), HasSubstr("narrower than the view"));
}

}  // namespace
}  // namespace gaitcam
