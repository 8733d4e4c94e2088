#include "algorithms/features/synthetic_blur.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/algorithms/features/picture.h"

namespace gaitcam {
namespace {

const cv::Size kBlurred(200, 160);
const std::vector<BlurKind> kKinds = {BlurKind::kLine, BlurKind::kRamp, BlurKind::kArc, BlurKind::kJitter,
                                      BlurKind::kRotation};

Eigen::Vector2d MeanOverTime(const BlurPath& path) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i + 1 < path.points.size(); ++i)
    mean += 0.5 * (path.points[i] + path.points[i + 1]) / double(path.points.size() - 1);
  return mean;
}

TEST(SyntheticBlur, APathIsAsLongAsWasAskedFor) {
  for (const BlurKind kind : {BlurKind::kLine, BlurKind::kRamp, BlurKind::kArc})
    for (const uint64_t seed : {1, 2, 3})
      EXPECT_NEAR(DrawMotion(kind, 17, kBlurred, seed).PathAt({30, 40}).Length(), 17, 0.02);  // chords of an arc
  std::vector<double> lengths;
  const ImageMotion turn = DrawMotion(BlurKind::kRotation, 17, kBlurred, 1);
  for (int y = 0; y < kBlurred.height; y += 5)
    for (int x = 0; x < kBlurred.width; x += 5) lengths.push_back(turn.PathAt({double(x), double(y)}).Length());
  std::nth_element(lengths.begin(), lengths.begin() + long(lengths.size() / 2), lengths.end());
  EXPECT_NEAR(lengths[lengths.size() / 2], 17, 0.4);  // another grid of pixels than the median was taken on
}

TEST(SyntheticBlur, NothingMovesOnAverage) {
  for (const BlurKind kind : kKinds)
    EXPECT_LT(MeanOverTime(DrawMotion(kind, 25, kBlurred, 4).PathAt({99.5, 79.5})).norm(), 1e-6);
}

TEST(SyntheticBlur, EachKindIsWhatItsNameSays) {
  const auto speeds = [](const BlurPath& p) {
    const size_t n = p.points.size();
    return std::pair((p.points[1] - p.points[0]).norm(), (p.points[n - 1] - p.points[n - 2]).norm());
  };
  const auto [slow, fast] = std::minmax({speeds(DrawMotion(BlurKind::kRamp, 20, kBlurred, 5).PathAt({0, 0})).first,
                                         speeds(DrawMotion(BlurKind::kRamp, 20, kBlurred, 5).PathAt({0, 0})).second});
  EXPECT_NEAR(fast / slow, 5, 0.25);  // the first and last of 88 steps are not quite the ends
  const BlurPath arc = DrawMotion(BlurKind::kArc, 20, kBlurred, 5).PathAt({0, 0});
  EXPECT_NEAR(arc.Chord().extent_px, 20 * std::sqrt(8) / M_PI, 0.02);
  const BlurPath shaken = DrawMotion(BlurKind::kJitter, 20, kBlurred, 5).PathAt({0, 0});
  const Eigen::Vector2d across = (shaken.points.back() - shaken.points.front()).unitOrthogonal();
  double off = 0;
  for (const Eigen::Vector2d& p : shaken.points) off = std::max(off, std::abs(across.dot(p)));
  EXPECT_GT(off, 0.3);
  EXPECT_LT(off, 1.5 * std::sqrt(2) * 2);  // either side of the mean, both axes at once
  const ImageMotion turn = DrawMotion(BlurKind::kRotation, 20, kBlurred, 5);
  EXPECT_LT(turn.PathAt(turn.centre).Length(), 1e-9);
  EXPECT_NEAR(turn.PathAt(turn.centre + Eigen::Vector2d(80, 0)).Length(),
              2 * turn.PathAt(turn.centre + Eigen::Vector2d(0, 40)).Length(), 1e-6);
}

TEST(SyntheticBlur, AnEvenLineIsTheLineBlur) {
  const cv::Mat picture = Values(RandomPicture(kBlurred, 3));
  const ImageMotion motion = DrawMotion(BlurKind::kLine, 14, kBlurred, 6);
  cv::Mat line;
  cv::filter2D(picture, line, CV_32F, LineBlurKernel(motion.PathAt({0, 0}).Chord()), {-1, -1}, 0,
               cv::BORDER_REFLECT_101);
  EXPECT_LT(cv::norm(BlurAlong(picture, motion), line, cv::NORM_INF), 0.03);  // warpAffine rounds to 1/32 px
}

TEST(SyntheticBlur, APointOfLightBecomesItsPath) {
  for (const BlurKind kind : kKinds) {
    cv::Mat point = cv::Mat::zeros(kBlurred, CV_32FC1);
    point.at<float>(50, 140) = 1;
    const ImageMotion motion = DrawMotion(kind, 16, kBlurred, 7);
    const BlurPath path = motion.PathAt({140, 50});
    const cv::Mat seen = BlurAlong(point, motion);
    double covered = 0;
    for (int y = 0; y < seen.rows; ++y)
      for (int x = 0; x < seen.cols; ++x) {
        const Eigen::Vector2d at(x - 140, y - 50);
        for (const Eigen::Vector2d& p : path.points)
          if ((p - at).lpNorm<Eigen::Infinity>() < 1.1) {
            covered += double(seen.at<float>(y, x));
            break;
          }
      }
    EXPECT_NEAR(covered, 1, 0.02) << int(kind);
  }
}

TEST(SyntheticBlur, TheSeedDecides) {
  for (const BlurKind kind : kKinds) {
    const BlurPath a = DrawMotion(kind, 16, kBlurred, 1).PathAt({10, 20}),
                   again = DrawMotion(kind, 16, kBlurred, 1).PathAt({10, 20});
    for (size_t i = 0; i < a.points.size(); ++i) EXPECT_EQ(a.points[i], again.points[i]);
  }
  EXPECT_NE(DrawMotion(BlurKind::kArc, 16, kBlurred, 1).PathAt({0, 0}).points[0],
            DrawMotion(BlurKind::kArc, 16, kBlurred, 2).PathAt({0, 0}).points[0]);
}

}  // namespace
}  // namespace gaitcam
