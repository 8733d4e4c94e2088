// What all detectors that know about blur promise: mobif, mobif_fast, mobif_restore, mobif_adapt.

#include "algorithms/features/mobif.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/features/features.h"
#include "algorithms/features/matching.h"
#include "algorithms/features/mobif_adapt.h"
#include "algorithms/features/mobif_restore.h"
#include "algorithms/features/synthetic_blur.h"
#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

constexpr int kMargin = 24;
const std::vector<std::string> kAll = {"mobif", "mobif_adapt", "mobif_fast", "mobif_restore"};

/// Matches between an image and another of the same view that are at the same place.
int CorrectMatches(const std::string& detector, const cv::Mat& a, const cv::Mat& b) {
  const Features of_a = DetectFeatures(*MakeFeature2d(detector), a, 10000);
  const Features of_b = DetectFeatures(*MakeFeature2d(detector), b, 10000);
  MatchingOptions options;
  options.ratio = 0.8;
  int correct = 0;
  for (const Match& m : MatchDescriptors(of_a.descriptors, of_b.descriptors, options))
    correct += cv::norm(of_a.keypoints[size_t(m.a)].pt - of_b.keypoints[size_t(m.b)].pt) < 2;
  return correct;
}

struct Views {
  cv::Mat sharp, blurred;
};

Views Film(double extent_px) {
  const cv::Mat picture = RandomPicture({448, 368}, 7);
  return {BlurAndCrop(picture, {}, kMargin), BlurAndCrop(picture, {extent_px, 0.5}, kMargin)};
}

TEST(Mobif, FindsAgainWhatSiftLosesToBlur) {
  const Views views = Film(20);
  const int sift = CorrectMatches("sift", views.sharp, views.blurred);
  EXPECT_GT(CorrectMatches("mobif", views.sharp, views.blurred), 5 * sift);
  EXPECT_GT(CorrectMatches("mobif_fast", views.sharp, views.blurred), 4 * sift);
  EXPECT_GT(CorrectMatches("mobif_restore", views.sharp, views.blurred), sift);
  EXPECT_GT(CorrectMatches("mobif_adapt", views.sharp, views.blurred), sift);
}

TEST(Mobif, LosesNothingToSiftOnASharpImage) {
  const Views views = Film(0);
  cv::Mat noisy = views.sharp.clone(), noise(noisy.size(), CV_16SC1);
  cv::RNG rng(1);
  rng.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(noisy, noise, noisy, cv::noArray(), CV_8U);
  EXPECT_GT(CorrectMatches("mobif", views.sharp, noisy), CorrectMatches("sift", views.sharp, noisy));
}

TEST(Mobif, TheSameBitsForAnyNumberOfThreads) {
  const Views views = Film(15);
  const int before = cv::getNumThreads();
  for (const std::string& name : kAll) {
    cv::setNumThreads(1);
    const Features one = DetectFeatures(*MakeFeature2d(name), views.blurred, 10000);
    cv::setNumThreads(8);
    const Features eight = DetectFeatures(*MakeFeature2d(name), views.blurred, 10000);
    ASSERT_EQ(one.size(), eight.size()) << name;
    ASSERT_GT(one.size(), 50) << name;
    EXPECT_EQ(cv::norm(one.descriptors, eight.descriptors, cv::NORM_INF), 0) << name;
    for (int i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one.keypoints[size_t(i)].pt, eight.keypoints[size_t(i)].pt);
      EXPECT_EQ(one.keypoints[size_t(i)].angle, eight.keypoints[size_t(i)].angle);
    }
  }
  cv::setNumThreads(before);
}

TEST(Mobif, OneImageHandsNothingToTheNext) {
  const Views views = Film(15);
  for (const std::string& name : kAll) {
    const cv::Ptr<cv::Feature2D> used = MakeFeature2d(name);
    DetectFeatures(*used, views.sharp, 10000);
    const Features after = DetectFeatures(*used, views.blurred, 10000);
    const Features fresh = DetectFeatures(*MakeFeature2d(name), views.blurred, 10000);
    ASSERT_EQ(after.size(), fresh.size()) << name;
    EXPECT_EQ(cv::norm(after.descriptors, fresh.descriptors, cv::NORM_INF), 0) << name;
  }
}

TEST(Mobif, NothingToSeeGivesNoFeatures) {
  for (const std::string& name : kAll)
    for (const cv::Mat& image : {cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)), cv::Mat(240, 320, CV_8UC1, cv::Scalar(255)),
                                 cv::Mat(240, 320, CV_8UC1, cv::Scalar(93)), cv::Mat(1, 1, CV_8UC1, cv::Scalar(7)),
                                 cv::Mat(5, 400, CV_8UC1, cv::Scalar(7)), cv::Mat()}) {
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      MakeFeature2d(name)->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
      EXPECT_TRUE(keypoints.empty()) << name << image.size();
      EXPECT_EQ(descriptors.rows, 0);
    }
}

TEST(Mobif, SmallAndNoisyImagesDoNoHarm) {
  cv::RNG rng(3);
  for (const std::string& name : kAll)
    for (const cv::Size size : {cv::Size(24, 24), cv::Size(31, 97), cv::Size(64, 48), cv::Size(130, 61)}) {
      cv::Mat noise(size, CV_8UC1);
      rng.fill(noise, cv::RNG::UNIFORM, 0, 256);
      const Features features = DetectFeatures(*MakeFeature2d(name), noise, 10000);
      for (const cv::KeyPoint& k : features.keypoints) {
        EXPECT_TRUE(std::isfinite(k.pt.x) && std::isfinite(k.pt.y) && std::isfinite(k.size) && std::isfinite(k.angle));
        EXPECT_TRUE(cv::Rect2f({-0.5f, -0.5f}, size).contains(k.pt)) << name << k.pt;
      }
      EXPECT_TRUE(features.descriptors.empty() || cv::checkRange(features.descriptors)) << name;
    }
}

TEST(Mobif, AKnownBlurIsTakenInsteadOfAnEstimate) {
  const Views views = Film(18);
  for (const cv::Ptr<BlurAwareFeature>& detector : {MakeMobif(), MakeMobifRestore(), MakeMobifAdapt()}) {
    std::vector<cv::KeyPoint> sharp, told, again;
    cv::Mat descriptors;
    detector->detectAndCompute(views.blurred, cv::noArray(), again, descriptors);
    const size_t estimated = again.size();
    detector->SetBlur(LineBlur{});
    detector->detectAndCompute(views.blurred, cv::noArray(), sharp, descriptors);
    detector->SetBlur(LineBlur{18, 0.5});
    detector->detectAndCompute(views.blurred, cv::noArray(), told, descriptors);
    EXPECT_NE(told.size(), sharp.size());
    detector->SetBlur(std::nullopt);
    detector->detectAndCompute(views.blurred, cv::noArray(), again, descriptors);
    EXPECT_EQ(again.size(), estimated);
  }
}

TEST(Mobif, ABlurBelowTheLimitIsLeftAlone) {
  const Views views = Film(18);
  const cv::Ptr<BlurAwareFeature> detector = MakeMobif();
  const auto positions = [&] {
    std::vector<cv::Point2f> points;
    for (const cv::KeyPoint& k : DetectFeatures(*detector, views.blurred, kAllFeatures).keypoints)
      points.push_back(k.pt);
    return points;
  };
  const auto by_itself = positions();
  detector->SetMinBlur(10);
  EXPECT_EQ(positions(), by_itself);
  detector->SetMinBlur(30);
  const auto left_alone = positions();
  detector->SetBlur(LineBlur{});
  EXPECT_EQ(left_alone, positions());
  EXPECT_NE(left_alone, by_itself);
  EXPECT_THROW(MakeMobifAdapt()->SetMinBlur(10), BadOption);
}

TEST(Mobif, SaddlePointsComeAfterBlobsOrNotAtAll) {
  const cv::Mat image = Film(0).sharp;
  const cv::Ptr<BlurAwareFeature> detector = MakeMobif(MobifOptions());
  const auto strongest = [&](SaddleUse use, int most) {
    detector->SetSaddleUse(use);
    return DetectFeatures(*detector, image, most);
  };
  const auto same = [](const Features& a, const Features& b, int rows) {
    return cv::norm(a.descriptors.rowRange(0, rows), b.descriptors.rowRange(0, rows), cv::NORM_INF) == 0;
  };
  const Features blobs = DetectFeatures(*MakeMobif(MobifBlobsOptions()), image, 100);
  ASSERT_EQ(blobs.size(), 100);
  EXPECT_TRUE(same(strongest(SaddleUse::kAfterBlobs, 100), blobs, 100));
  EXPECT_TRUE(same(strongest(SaddleUse::kNone, 100), blobs, 100));
  EXPECT_FALSE(same(strongest(SaddleUse::kByStrength, 100), blobs, 100)) << "the strongest are of both kinds";
  const int all_blobs = strongest(SaddleUse::kNone, 100000).size();
  const int all = strongest(SaddleUse::kAfterBlobs, 100000).size();
  EXPECT_GT(all, 1.2 * all_blobs);
  EXPECT_EQ(strongest(SaddleUse::kByStrength, 100000).size(), all);
}

TEST(Mobif, RegionsThatShareABlurAreAboutOneImage) {
  const Views views = Film(18);
  const int w = views.blurred.cols, h = views.blurred.rows;
  const BlurEstimate certain{{18, 0.5}, 1, true};
  for (const cv::Ptr<BlurAwareFeature>& detector : {MakeMobif(), MakeMobifAdapt()}) {
    detector->SetBlur(certain.blur);
    const Features one = DetectFeatures(*detector, views.blurred, 10000);
    detector->SetBlurRegions({{{0, 0, w / 2, h}, certain}, {{w / 2, 0, w - w / 2, h}, certain}});
    const Features two = DetectFeatures(*detector, views.blurred, 10000);
    int same = 0;
    for (const Match& m : MatchDescriptors(one.descriptors, two.descriptors, {}))
      same += cv::norm(one.keypoints[size_t(m.a)].pt - two.keypoints[size_t(m.b)].pt) < 0.5;
    EXPECT_GT(same, 0.6 * one.size());  // the rest lies near the seam or the border
  }
}

TEST(Mobif, IsAnOpenCvDetector) {
  const cv::Mat grey = Film(0).sharp;
  cv::Mat colour, mask = cv::Mat::zeros(grey.size(), CV_8UC1);
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  mask.colRange(0, 100) = 255;
  for (const std::string& name : kAll) {
    const cv::Ptr<cv::Feature2D> detector = MakeFeature2d(name);
    std::vector<cv::KeyPoint> of_grey, of_colour, masked;
    cv::Mat descriptors;
    detector->detect(grey, of_grey);
    detector->detectAndCompute(colour, cv::noArray(), of_colour, descriptors);
    EXPECT_EQ(of_grey.size(), of_colour.size()) << name;
    EXPECT_EQ(descriptors.rows, int(of_colour.size()));
    EXPECT_EQ(descriptors.cols, detector->descriptorSize());
    EXPECT_EQ(descriptors.type(), detector->descriptorType());
    detector->detectAndCompute(grey, mask, masked, descriptors);
    EXPECT_LT(masked.size(), of_grey.size());
    EXPECT_EQ(descriptors.rows, int(masked.size()));
    for (const cv::KeyPoint& k : masked) EXPECT_LT(k.pt.x, 100);
  }
}

TEST(Mobif, MatchesLieWhereTheSharpImageHasThem) {
  // The pixel convention survives restoration: matches of the sharp with the blurred image are off by nothing on
  // average.
  const Views views = Film(16);
  for (const cv::Ptr<BlurAwareFeature>& detector : {MakeMobif(), MakeMobifRestore(), MakeMobifAdapt()}) {
    detector->SetBlur(LineBlur{});
    const Features a = DetectFeatures(*detector, views.sharp, 10000);
    detector->SetBlur(LineBlur{16, 0.5});
    const Features b = DetectFeatures(*detector, views.blurred, 10000);
    cv::Point2d sum(0, 0);
    int n = 0;
    for (const Match& m : MatchDescriptors(a.descriptors, b.descriptors, {})) {
      const cv::Point2f d = b.keypoints[size_t(m.b)].pt - a.keypoints[size_t(m.a)].pt;
      if (cv::norm(d) > 2) continue;
      sum += cv::Point2d(d);
      ++n;
    }
    ASSERT_GT(n, 100);
    EXPECT_NEAR(sum.x / n, 0, 0.17);  // three standard errors of 0.57 px per axis over 100 matches
    EXPECT_NEAR(sum.y / n, 0, 0.17);
  }
}

int CorrectAgainst(const Features& of_sharp, const Features& others) {
  int correct = 0;
  for (const Match& m : MatchDescriptors(of_sharp.descriptors, others.descriptors, {}))
    correct += cv::norm(of_sharp.keypoints[size_t(m.a)].pt - others.keypoints[size_t(m.b)].pt) < 2;
  return correct;
}

TEST(Mobif, AKnownPathIsWorthManyTimesItsChord) {
  const cv::Mat picture = RandomPicture({448, 368}, 7);
  const Features sharp = DetectFeatures(*MakeMobif(), BlurAndCrop(picture, {}, kMargin), 10000);
  for (const BlurKind kind : {BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter}) {
    const ImageMotion motion = DrawMotion(kind, 20, picture.size(), 3);
    const BlurPath path = motion.PathAt({0, 0});
    cv::Mat blurred = BlurAlong(Values(picture), motion);
    blurred = blurred(cv::Rect(kMargin, kMargin, picture.cols - 2 * kMargin, picture.rows - 2 * kMargin));
    blurred.convertTo(blurred, CV_8U, 255);
    const cv::Rect whole({0, 0}, blurred.size());
    const cv::Ptr<BlurAwareFeature> mobif = MakeMobif();
    mobif->SetBlurRegions({{whole, {path.Chord(), 1, true}, path}});
    const int along = CorrectAgainst(sharp, DetectFeatures(*mobif, blurred, 10000));
    mobif->SetBlurRegions({{whole, {path.Chord(), 1, true}}});
    EXPECT_GT(along, 1.5 * CorrectAgainst(sharp, DetectFeatures(*mobif, blurred, 10000))) << int(kind);
    EXPECT_GT(along, 5 * CorrectMatches("sift", BlurAndCrop(picture, {}, kMargin), blurred)) << int(kind);
  }
}

TEST(Mobif, LookingForPathsChangesNothingOnASharpImageOrAClearLine) {
  for (const double extent : {0.0, 20.0}) {
    const cv::Mat image = Film(extent).blurred;
    const Features plain = DetectFeatures(*MakeFeature2d("mobif"), image, 10000);
    const Features looked = DetectFeatures(*MakeFeature2d("mobif_path"), image, 10000);
    ASSERT_EQ(plain.size(), looked.size()) << extent;
    EXPECT_EQ(cv::norm(plain.descriptors, looked.descriptors, cv::NORM_INF), 0) << extent;
  }
}

TEST(Mobif, AFineTextureThatIsSharpHasItsPoints) {
  cv::Mat fine(360, 480, CV_8UC1);
  cv::RNG rng(5);
  rng.fill(fine, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(fine, fine, {0, 0}, 1.5);
  cv::normalize(fine, fine, 0, 255, cv::NORM_MINMAX);
  MobifOptions capped = MobifFastOptions();
  capped.sharp_points_per_megapixel = capped.points_per_megapixel;
  const int few = DetectFeatures(*MakeMobif(capped), fine, 100000).size();
  EXPECT_GT(DetectFeatures(*MakeFeature2d("mobif_fast"), fine, 100000).size(),
            1.4 * few);  // 14 to 8; a point may have two orientations
}

TEST(Mobif, RefusesUnknownEstimatorsAndLight) {
  MobifOptions options;
  options.psf = "spectrall";
  EXPECT_THROW(MakeMobif(options), BadInput);
  options = {};
  options.light = static_cast<BlurDomain>(3);
  EXPECT_THROW(MakeMobif(options), BadOption);
}

}  // namespace
}  // namespace gaitcam
