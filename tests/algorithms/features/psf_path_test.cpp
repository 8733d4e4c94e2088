#include "algorithms/features/psf_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/features/light_response.h"
#include "algorithms/features/synthetic_blur.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {
namespace {

using psf_test::Photograph;

constexpr int kSeen = 420;  ///< px: small enough to be quick.

/// The middle of a photograph, moved while the shutter was open.
cv::Mat Moved(const std::string& name, const ImageMotion& motion, bool of_light) {
  const cv::Mat grey = Photograph(name);
  cv::Mat values;
  grey.convertTo(values, CV_32F, 1 / 255.0);
  if (of_light) values = LightOfGrey(grey);
  values = BlurAlong(values, motion);
  if (of_light) values = GreyOfLight(values);
  const cv::Size size(std::min(kSeen, grey.cols - 60), std::min(kSeen, grey.rows - 60));
  cv::Mat filmed;
  values(cv::Rect({(grey.cols - size.width) / 2, (grey.rows - size.height) / 2}, size)).convertTo(filmed, CV_8U, 255);
  return filmed;
}

cv::Mat AsValues(const cv::Mat& grey) {
  cv::Mat values;
  grey.convertTo(values, CV_32F, 1 / 255.0);
  return values;
}

BlurPath OffBy(BlurPath path, const Eigen::Vector2d& error) {
  for (size_t i = 0; i < path.points.size(); ++i)
    path.points[i] += (double(i) / double(path.points.size() - 1) - 0.5) * error;
  return path;
}

TEST(PathSpectrum, TheTruePathAgreesBestAndWhereItsBlurActed) {
  for (const BlurKind kind : {BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter})
    for (const bool of_light : {false, true}) {
      const ImageMotion motion = DrawMotion(kind, 20, {640, 480}, 2);
      const BlurPath truth = motion.PathAt({0, 0});
      const cv::Mat seen = Moved("home.jpg", motion, of_light);
      const PathSpectrum display(AsValues(seen)), light(LightOfGrey(seen));
      const double agreement = (of_light ? light : display).Agreement(truth);
      EXPECT_GT(agreement, 0.4) << int(kind);
      EXPECT_GT(agreement, (of_light ? display : light).Agreement(truth)) << int(kind);
      EXPECT_GT(agreement, (of_light ? light : display).Agreement(OffBy(truth, {2, -1}))) << int(kind);
      EXPECT_EQ(PathsActedOnLight(seen, {{cv::Rect({0, 0}, seen.size()), {}, truth}}), of_light) << int(kind);
    }
}

TEST(PathSpectrum, APathThatIsOffByAPixelIsSetRight) {
  const ImageMotion motion = DrawMotion(BlurKind::kArc, 20, {640, 480}, 3);
  const BlurPath truth = motion.PathAt({0, 0}), prior = OffBy(truth, {0.8, 0.6});
  const PathSpectrum spectrum(AsValues(Moved("leuvenA.jpg", motion, false)));
  const PathFit fit = spectrum.Refine(prior, 1);
  EXPECT_GT(PathDistance(prior, truth), 0.25);
  EXPECT_LT(PathDistance(fit.path, truth), 0.15);
}

TEST(EstimatePath, FindsBentAndUnevenPathsTheRightWayRound) {
  for (const BlurKind kind : {BlurKind::kRamp, BlurKind::kArc}) {
    const ImageMotion motion = DrawMotion(kind, 18, {640, 480}, 4);
    const BlurPath truth = Resampled(motion.PathAt({0, 0}), 33);
    const PathEstimate found = EstimatePath(Moved("home.jpg", motion, false), {});
    EXPECT_LT(PathDistance(found.path, truth), 1) << int(kind);
    EXPECT_FALSE(found.of_light) << int(kind);
    EXPECT_GT(found.confidence, 0.6) << int(kind);
    // Either way in time, but not turned by half a turn.
    const BlurPath path = Resampled(found.path, 33);
    double as_is = 0, backwards = 0, turned = 0, turned_backwards = 0;
    for (size_t i = 0; i < 33; ++i) {
      as_is += (path.points[i] - truth.points[i]).squaredNorm();
      backwards += (path.points[32 - i] - truth.points[i]).squaredNorm();
      turned += (path.points[i] + truth.points[i]).squaredNorm();
      turned_backwards += (path.points[32 - i] + truth.points[i]).squaredNorm();
    }
    EXPECT_LT(std::min(as_is, backwards), std::min(turned, turned_backwards)) << int(kind);
  }
}

TEST(EstimatePath, ALineThatExplainsAsMuchIsKept) {
  const ImageMotion motion = DrawMotion(BlurKind::kLine, 18, {640, 480}, 5);
  const cv::Mat seen = Moved("home.jpg", motion, false);
  EXPECT_TRUE(EstimatePath(seen, motion.PathAt({0, 0}).Chord()).straight);
}

TEST(EstimatePath, IsNotSureOfASharpImage) {
  EXPECT_LT(EstimatePath(Moved("home.jpg", {}, false), {}).confidence, 0.5);
}

TEST(EstimatePath, NothingToSeeIsNoPath) {
  for (const cv::Mat& image : {cv::Mat(200, 200, CV_8UC1, cv::Scalar(90)), cv::Mat(20, 300, CV_8UC1, cv::Scalar(9))}) {
    const PathEstimate found = EstimatePath(image, {});
    EXPECT_TRUE(found.path.empty());
    EXPECT_EQ(found.confidence, 0);
  }
}

}  // namespace
}  // namespace gaitcam
