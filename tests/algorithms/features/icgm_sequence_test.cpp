#include "algorithms/features/icgm_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "algorithms/core/units.h"
#include "tests/algorithms/features/picture.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

constexpr int kSide_px = 400;

FeatureImage Seen(const cv::Mat& image, const std::string& detector) {
  return {image.size(), DetectFeatures(*MakeFeature2d(detector), image, 400)};
}

/// Parts of one picture that the camera pans over.
std::vector<FeatureImage> PannedPicture(const std::string& detector, int count, int step_px) {
  const cv::Mat picture = RandomPicture({kSide_px + count * step_px, kSide_px}, 5);
  std::vector<FeatureImage> images;
  for (int i = 0; i < count; ++i)
    images.push_back(Seen(picture(cv::Rect(i * step_px, 0, kSide_px, kSide_px)).clone(), detector));
  return images;
}

class PirfAndIcgm : public testing::TestWithParam<std::string> {};

// Hua, section 4.1.5.
TEST_P(PirfAndIcgm, WithoutAThresholdIcgmIsPirfOfWindowTwo) {
  const std::vector<FeatureImage> images = PannedPicture(GetParam(), 4, 25);
  PirfOptions pirf;
  pirf.window = 2;
  RobustFeatureOptions options;
  options.icgm.threshold = 1;
  const std::vector<PirfSet> sets = ExtractPirf(images, pirf);
  ASSERT_EQ(sets.size(), 3u);
  for (int t = 1; t < 4; ++t) {
    std::vector<int> rows;
    for (const std::vector<int>& chain : sets[size_t(t - 1)].rows) rows.push_back(chain.back());
    std::sort(rows.begin(), rows.end());
    EXPECT_GT(rows.size(), 20u);
    RandomStream random(uint64_t(t), "icgm");
    EXPECT_EQ(RobustFeatures(images, t, options, random), rows) << t;
  }
}

TEST_P(PirfAndIcgm, ALongerWindowKeepsASubset) {
  const std::vector<FeatureImage> images = PannedPicture(GetParam(), 4, 25);
  std::set<int> before;
  for (int window = 2; window <= 4; ++window) {
    PirfOptions options;
    options.window = window;
    std::set<int> rows;
    const std::vector<PirfSet> sets = ExtractPirf(images, options);
    for (const std::vector<int>& chain : sets.back().rows) rows.insert(chain.back());
    EXPECT_EQ(sets.back().descriptors.rows, int(sets.back().rows.size()));
    EXPECT_FALSE(rows.empty());
    if (window > 2) {
      EXPECT_TRUE(std::includes(before.begin(), before.end(), rows.begin(), rows.end()));
      EXPECT_LT(rows.size(), before.size());
    }
    before = rows;
  }
}

INSTANTIATE_TEST_SUITE_P(Detectors, PirfAndIcgm, testing::Values("surf", "sift", "orb"),
                         [](const auto& info) { return info.param; });

TEST(Pirf, DescribesAFeatureByItsMeanOverTheWindow) {
  const std::vector<FeatureImage> images = PannedPicture("sift", 3, 10);
  const PirfSet set = ExtractPirf(images, {}).front();
  ASSERT_GT(set.rows.size(), 10u);
  for (size_t i = 0; i < set.rows.size(); ++i) {
    cv::Mat sum = cv::Mat::zeros(1, 128, CV_32F);
    for (size_t k = 0; k < 3; ++k) sum += images[k].features.descriptors.row(set.rows[i][k]);
    EXPECT_LT(cv::norm(sum / 3, set.descriptors.row(int(i))), 1e-3);
  }
}

TEST(Pirf, HasOneSetForEveryWindowAndNoneForTooFewImages) {
  const std::vector<FeatureImage> images = PannedPicture("orb", 4, 10);
  EXPECT_EQ(ExtractPirf(images, {}).size(), 2u);
  EXPECT_TRUE(ExtractPirf({images.data(), 2}, {}).empty());
}

TEST(Pirf, RefusesImagesOfDifferentSizesInOneLine) {
  std::vector<FeatureImage> images = PannedPicture("orb", 2, 10);
  images[1].size_px = {300, 200};
  PirfOptions options;
  options.window = 2;
  EXPECT_THAT(ErrorOf([&] { ExtractPirf(images, options); }),
              HasSubstr("image 1 of a window: 300 x 200 px; expected 400 x 400 px"));
  options.window = 1;
  EXPECT_THAT(ErrorOf([&] { ExtractPirf(images, options); }), HasSubstr("pirf.window: 1 is not permitted"));
}

/// Features whose descriptors tell them apart without error, where they are seen.
class Landmarks {
 public:
  explicit Landmarks(int count) : descriptors_(count, 32, CV_32FC1) {
    RandomStream random(3, "landmarks");
    for (float& value : cv::Mat_<float>(descriptors_)) value = float(random.Uniform());
  }
  /// @param project where a landmark is seen, if it is.
  template <class Project>
  FeatureImage See(Project project) const {
    FeatureImage image{{kSide_px, kSide_px}, {}};
    image.features.descriptors = cv::Mat(0, 32, CV_32FC1);
    for (int i = 0; i < descriptors_.rows; ++i) {
      const std::optional<cv::Point2f> pixel = project(i);
      if (!pixel) continue;
      image.features.keypoints.emplace_back(*pixel, 1.f);
      image.features.descriptors.push_back(descriptors_.row(i));
    }
    return image;
  }

 private:
  cv::Mat descriptors_;
};

double KeptShare(const std::vector<FeatureImage>& images, IcgmDirection direction, double threshold) {
  RobustFeatureOptions options;
  options.direction = direction;
  options.icgm.threshold = threshold;
  RandomStream random(1, "share");
  return double(RobustFeatures(images, 1, options, random).size()) / images[1].features.size();
}

constexpr double kHalfView = 30 * kRadPerDeg;

std::optional<cv::Point2f> PixelOf(double x, double y) {
  const double half = std::tan(kHalfView);
  if (std::abs(x) > half || std::abs(y) > half) return std::nullopt;
  return cv::Point2f(float(kSide_px / 2 * (1 + x / half)), float(kSide_px / 2 * (1 + y / half)));
}

// Hua, Fig. 4.4. Of some 500 landmarks in view, a share has a standard deviation of 0.022 at most; 4 of them.
TEST(RobustFeatures, ATurningCameraKeepsTheSharesOfTheEquations) {
  constexpr int kCount = 3000;
  RandomStream random(8, "turning");
  std::vector<double> angle, height;
  for (int i = 0; i < kCount; ++i) {
    angle.push_back(random.Uniform(-kPi, kPi));
    height.push_back(random.Uniform(-0.3, 0.3));  // in view whatever the angle
  }
  const Landmarks landmarks(kCount);
  for (const double lambda : {0.0, 0.2, 0.45, 0.6, 0.8, 1.1}) {
    std::vector<FeatureImage> images;
    for (const int t : {-1, 0, 1}) {
      images.push_back(landmarks.See([&](int i) -> std::optional<cv::Point2f> {
        const double seen = angle[size_t(i)] - t * lambda * 2 * kHalfView;
        if (std::abs(seen) > kHalfView) return std::nullopt;
        return PixelOf(std::tan(seen), height[size_t(i)]);
      }));
    }
    for (const IcgmDirection direction : {IcgmDirection::kSingle, IcgmDirection::kDouble}) {
      const double expected = TurningShare(lambda, direction);
      EXPECT_NEAR(KeptShare(images, direction, 1), expected, 0.09) << lambda;
      // A turn bends the image, so that ICGM cannot keep more than what is in view twice.
      EXPECT_LE(KeptShare(images, direction, 0.08), expected + 0.09) << lambda;
    }
  }
}

// Hua, Fig. 4.5.
TEST(RobustFeatures, ARecedingCameraKeepsTheSharesOfTheEquations) {
  constexpr int kCount = 3000;
  RandomStream random(9, "receding");
  std::vector<double> x, y;
  for (int i = 0; i < kCount; ++i) {
    x.push_back(random.Uniform(-1.8, 1.8));
    y.push_back(random.Uniform(-1.8, 1.8));
  }
  const Landmarks landmarks(kCount);
  for (const double lambda : {0.1, 0.3, 0.6}) {
    std::vector<FeatureImage> images;  // the wall is 1 away in the middle one
    for (const int t : {-1, 0, 1})
      images.push_back(landmarks.See([&](int i) {
        const double depth = 1 + t * lambda;
        return PixelOf(x[size_t(i)] / depth, y[size_t(i)] / depth);
      }));
    for (const IcgmDirection direction : {IcgmDirection::kSingle, IcgmDirection::kDouble})
      EXPECT_NEAR(KeptShare(images, direction, 1), RecedingShare(lambda, direction), 0.09) << lambda;
    std::reverse(images.begin(), images.end());  // it approaches: nothing comes into view
    EXPECT_EQ(KeptShare(images, IcgmDirection::kSingle, 1), 1) << lambda;
    // Of pure zoom all ratios are (z - 1) / (z + 1), here between the image before and the one in the middle.
    const double ratio = lambda / (2 + lambda);
    EXPECT_EQ(KeptShare(images, IcgmDirection::kSingle, ratio + 1e-4), 1) << lambda;
    EXPECT_EQ(KeptShare(images, IcgmDirection::kSingle, ratio - 1e-4), 0) << lambda;
  }
}

TEST(RobustFeatures, DoubleKeepsWhatEitherSideKeepsAndEndsHaveOneSide) {
  const std::vector<FeatureImage> images = PannedPicture("sift", 3, 60);
  const auto rows = [&](int t, IcgmDirection direction) {
    RobustFeatureOptions options;
    options.direction = direction;
    options.icgm = IcgmOptions::Consensus();  // draws nothing
    RandomStream random(1, "double");
    return RobustFeatures(images, t, options, random);
  };
  EXPECT_TRUE(rows(0, IcgmDirection::kSingle).empty());
  EXPECT_FALSE(rows(0, IcgmDirection::kDouble).empty());
  EXPECT_EQ(rows(2, IcgmDirection::kSingle), rows(2, IcgmDirection::kDouble));
  const std::vector<int> one = rows(1, IcgmDirection::kSingle), both = rows(1, IcgmDirection::kDouble);
  EXPECT_TRUE(std::includes(both.begin(), both.end(), one.begin(), one.end()));
  EXPECT_GT(both.size(), one.size());
}

TEST(RobustFeatures, ABlankImageKeepsNothing) {
  std::vector<FeatureImage> images = PannedPicture("sift", 2, 20);
  images.push_back(Seen(cv::Mat(kSide_px, kSide_px, CV_8UC1, cv::Scalar(90)), "sift"));
  RandomStream random(1, "blank");
  EXPECT_TRUE(RobustFeatures(images, 2, {}, random).empty());
}

}  // namespace
}  // namespace gaitcam
