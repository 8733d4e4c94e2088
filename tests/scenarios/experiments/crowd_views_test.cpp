// What the crowds experiment is judged by: depth, labels and poses against the pictures themselves.

#include "scenarios/code/experiments/crowd_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/crowd_matches.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

CrowdOptions FullRoom() {
  CrowdOptions options;
  options.scene = "lab";
  options.people_per_100_m2 = 25;
  options.things = 8;
  return options;
}

/// Correlation of the grey values around two pixels; nothing near the border or where there is no texture.
std::optional<double> Likeness(const cv::Mat& a, const Vector2d& p, const cv::Mat& b, const Vector2d& q) {
  constexpr int kSide_px = 15;
  constexpr double kLeastContrast = 8;
  const cv::Rect inner(kSide_px, kSide_px, a.cols - 2 * kSide_px, a.rows - 2 * kSide_px);
  if (!inner.contains(cv::Point(int(p.x()), int(p.y()))) || !inner.contains(cv::Point(int(q.x()), int(q.y()))))
    return std::nullopt;
  cv::Mat patch_a, patch_b, correlation;
  cv::getRectSubPix(a, {kSide_px, kSide_px}, cv::Point2f(float(p.x()), float(p.y())), patch_a);
  cv::getRectSubPix(b, {kSide_px, kSide_px}, cv::Point2f(float(q.x()), float(q.y())), patch_b);
  cv::Scalar mean, contrast;
  cv::meanStdDev(patch_a, mean, contrast);
  if (contrast[0] < kLeastContrast) return std::nullopt;
  cv::matchTemplate(patch_a, patch_b, correlation, cv::TM_CCOEFF_NORMED);
  return double(correlation.at<float>(0));
}

class CrowdViews : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    CrowdStage stage(FullRoom(), 1);
    for (int i = 0; i < 3; ++i) pairs_.push_back(stage.Film(i));
  }
  static void TearDownTestSuite() { pairs_.clear(); }

  /// Every pixel of a grid over the first view, with the point that it sees.
  template <class Visit>
  static void ForPoints(const CrowdPair& pair, Visit visit) {
    for (int y = 4; y < pair.a.depth.rows; y += 7)
      for (int x = 4; x < pair.a.depth.cols; x += 7) {
        const Vector2d pixel(x, y);
        const float z = pair.a.depth.at<float>(y, x);
        if (z > 0) visit(pixel, pair.a.X_WC * Vector3d(double(z) * pair.camera.Unproject(pixel)));
      }
  }
  static const MovedThing* ThingAt(const CrowdPair& pair, const Vector3d& p_W) {
    for (const MovedThing& thing : pair.things) {
      const Vector3d p_B = thing.X_WB_a.Inverse() * p_W;
      if (((p_B.cwiseAbs() - 0.5 * thing.size).array() < 0.003).all()) return &thing;
    }
    return nullptr;
  }
  /// Where a point of the world is seen in the second view, if nothing stands before it.
  static std::optional<Vector2d> SeenInB(const CrowdPair& pair, const Vector3d& p_W) {
    const Vector3d p_C = pair.b.X_WC.Inverse() * p_W;
    const auto pixel = pair.camera.Project(p_C);
    const cv::Point at = pixel ? cv::Point(int(std::lround(pixel->x())), int(std::lround(pixel->y()))) : cv::Point();
    if (!pixel || !cv::Rect({}, pair.b.depth.size()).contains(at)) return std::nullopt;
    if (std::abs(pair.b.depth.at<float>(at) - p_C.z()) > 0.02 * p_C.z()) return std::nullopt;
    return pixel;
  }
  static std::vector<CrowdPair> pairs_;
};
std::vector<CrowdPair> CrowdViews::pairs_;

TEST_F(CrowdViews, WhatStandsStillLooksAlikeWhereTheTruthPutsIt) {
  std::vector<double> likeness, beside;
  for (const CrowdPair& pair : pairs_) {
    const PairTruth truth(pair);
    ForPoints(pair, [&](const Vector2d& a, const Vector3d& p_W) {
      const auto b = SeenInB(pair, p_W);
      if (!b || truth.Of(a, *b) == MatchTruth::kMover) return;
      EXPECT_EQ(truth.Of(a, *b), MatchTruth::kRight);
      EXPECT_LT(truth.Error(a, *b), 1e-6);
      if (const auto like = Likeness(pair.a.grey, a, pair.b.grey, *b)) likeness.push_back(*like);
      const Vector2d wrong = *b + Vector2d(12, 0);
      if (const auto like = Likeness(pair.a.grey, a, pair.b.grey, wrong)) beside.push_back(*like);
    });
  }
  ASSERT_GT(likeness.size(), 300u);
  EXPECT_GT(MedianOf(likeness), 0.8);  // not 1: the view has turned and come nearer
  EXPECT_LT(MedianOf(beside), 0.4);
}

TEST_F(CrowdViews, ThingsAreSeenElsewhereAndNeverRight) {
  std::vector<double> moved, stayed;
  for (const CrowdPair& pair : pairs_) {
    const PairTruth truth(pair);
    ForPoints(pair, [&](const Vector2d& a, const Vector3d& p_W) {
      const MovedThing* thing = ThingAt(pair, p_W);
      if (!thing || pair.a.on_people.at<uchar>(int(a.y()), int(a.x())) != 0) return;
      const Vector3d then = thing->X_WB_b * (thing->X_WB_a.Inverse() * p_W);
      if (const auto b = SeenInB(pair, then)) {
        EXPECT_EQ(truth.Of(a, *b), MatchTruth::kMover);
        if (const auto like = Likeness(pair.a.grey, a, pair.b.grey, *b)) moved.push_back(*like);
      }
      const auto before = pair.camera.Project(pair.b.X_WC.Inverse() * p_W);
      if (!before) return;
      if (const auto like = Likeness(pair.a.grey, a, pair.b.grey, *before)) stayed.push_back(*like);
    });
  }
  ASSERT_GT(moved.size(), 30u);
  EXPECT_GT(MedianOf(moved), MedianOf(stayed) + 0.2);
}

TEST_F(CrowdViews, PeopleAreMoversAndAPixelAsideIsWrong) {
  int people = 0, wrong = 0;
  for (const CrowdPair& pair : pairs_) {
    const PairTruth truth(pair);
    people += cv::countNonZero(pair.a.on_people);
    ForPoints(pair, [&](const Vector2d& a, const Vector3d& p_W) {
      if (pair.a.on_people.at<uchar>(int(a.y()), int(a.x())) != 0) {
        EXPECT_EQ(truth.Of(a, a), MatchTruth::kMover);
        return;
      }
      const auto b = SeenInB(pair, p_W);
      if (!b || truth.Of(a, *b) != MatchTruth::kRight) return;
      for (const double aside : {2.5, 40.0}) {
        const Vector2d other = *b - Vector2d(aside, 0);
        const MatchTruth judged = truth.Of(a, other);
        if (aside < 3)
          EXPECT_NE(judged, MatchTruth::kWrong);
        else
          wrong += judged == MatchTruth::kWrong;
      }
    });
  }
  EXPECT_GT(people, 1000);
  EXPECT_GT(wrong, 1000);
}

TEST_F(CrowdViews, APairIsTheSameWhateverWasFilmedBefore) {
  CrowdStage stage(FullRoom(), 1);
  const CrowdPair again = stage.Film(2);
  EXPECT_EQ(cv::norm(again.a.grey, pairs_[2].a.grey, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(again.b.grey, pairs_[2].b.grey, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(pairs_[0].a.grey, pairs_[2].a.grey, cv::NORM_INF), 50);
}

TEST_F(CrowdViews, FiltersKeepPartsAndNoneKeepsAll) {
  const JudgedMatches judged = MatchViews(pairs_[0], "sift");
  ASSERT_GT(judged.matches.size(), 30u);
  for (const MatchJudge& filter : CrowdFilters()) {
    const FilterScore score = ScoreOf(judged, filter.keep(judged));
    EXPECT_LE(score.kept, int(judged.matches.size())) << filter.name;
    EXPECT_LE(score.right, score.near) << filter.name;
    EXPECT_LE(score.near + score.movers, score.kept) << filter.name;
    EXPECT_EQ(filter.name == "none", score.kept == int(judged.matches.size())) << filter.name;
    EXPECT_EQ(filter.keep(judged), filter.keep(judged)) << filter.name;
  }
}

TEST(CrowdStage, RefusesASceneThatIsNotThere) {
  CrowdOptions options;
  options.scene = "labb";
  EXPECT_NE(ErrorOf([&] { CrowdStage(options, 1); }).find("labb"), std::string::npos);
}

}  // namespace
}  // namespace gaitcam
