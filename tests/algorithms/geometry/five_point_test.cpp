#include "algorithms/geometry/five_point.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/relative_pose/methods.hpp>

#include "tests/algorithms/geometry/view_pairs.h"

namespace gaitcam {
namespace {

std::vector<Eigen::Matrix3d> OpenCvFivePoint(const std::vector<PointPair>& five) {
  std::vector<cv::Point2d> a, b;
  for (const PointPair& pair : five) {
    a.emplace_back(pair.a.x(), pair.a.y());
    b.emplace_back(pair.b.x(), pair.b.y());
  }
  // With exactly five pairs OpenCV's estimator draws no sample: it returns all solutions, stacked.
  const cv::Mat stacked = cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.99, 1.0);
  std::vector<Eigen::Matrix3d> solutions;
  for (int row = 0; row + 3 <= stacked.rows; row += 3) {
    Eigen::Matrix3d E;
    for (int i = 0; i < 9; ++i) E(i / 3, i % 3) = stacked.at<double>(row + i / 3, i % 3);
    solutions.push_back(E);
  }
  return solutions;
}

std::vector<Eigen::Matrix3d> OpenGvFivePoint(const std::vector<PointPair>& five) {
  opengv::bearingVectors_t a, b;
  for (const PointPair& pair : five) {
    a.push_back(pair.a.homogeneous().normalized());
    b.push_back(pair.b.homogeneous().normalized());
  }
  opengv::relative_pose::CentralRelativeAdapter adapter(a, b);
  std::vector<Eigen::Matrix3d> solutions;
  for (const auto& E : opengv::relative_pose::fivept_nister(adapter)) solutions.push_back(E.transpose());
  return solutions;
}

double Nearest(const std::vector<Eigen::Matrix3d>& solutions, const Eigen::Matrix3d& truth) {
  double best = 2;
  for (const Eigen::Matrix3d& E : solutions) {
    if (E.allFinite()) best = std::min({best, EssentialDistance(E, truth), EssentialDistance(E.transpose(), truth)});
  }
  return best;
}

class EveryScene : public testing::TestWithParam<Scene> {};

TEST_P(EveryScene, FiveExactPairsGiveTheTrueMatrixAtLeastAsWellAsThePeersDo) {
  std::vector<double> ours, opencv, opengv_;
  int lost = 0, opencv_lost = 0, opengv_lost = 0;
  constexpr int kTrials = 1000;
  for (uint64_t seed = 0; seed < kTrials; ++seed) {
    const ViewPairs views = MakeViewPairs(GetParam(), RandomMotion(seed), 5, 0, 0, seed);
    const Eigen::Matrix3d truth = TrueEssential(views.X_AB);
    const auto solutions = SolveFivePoint(views.pairs);
    EXPECT_LE(solutions.size(), 10u);
    ours.push_back(Nearest(solutions, truth));
    opencv.push_back(Nearest(OpenCvFivePoint(views.pairs), truth));
    opengv_.push_back(Nearest(OpenGvFivePoint(views.pairs), truth));
    lost += ours.back() > 1e-4;
    opencv_lost += opencv.back() > 1e-4;
    opengv_lost += opengv_.back() > 1e-4;
  }
  RecordProperty("lost", lost);
  printf("median error: ours %.1e, OpenCV %.1e, OpenGV %.1e; lost of %d: %d, %d, %d\n", UpperMedian(ours),
         UpperMedian(opencv), UpperMedian(opengv_), kTrials, lost, opencv_lost, opengv_lost);
  EXPECT_LT(UpperMedian(ours), 1e-11);
  // All three solve a polynomial of degree ten in doubles: an order of magnitude is how they may differ by chance of
  // the elimination's order; it is nothing beside the noise of pixels (1e-3).
  EXPECT_LT(UpperMedian(ours), 10 * std::min(UpperMedian(opencv), UpperMedian(opengv_)));
  EXPECT_LE(lost, 10 + std::min(opencv_lost, opengv_lost));  // 1 % of samples more or less cost RANSAC nothing
}

INSTANTIATE_TEST_SUITE_P(, EveryScene, testing::Values(Scene::kDeep, Scene::kPlane),
                         [](const auto& info) { return info.param == Scene::kDeep ? "Deep" : "Plane"; });

TEST(FivePoint, SolutionsAreEssentialAndSatisfyTheFivePairs) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const ViewPairs views = MakeViewPairs(Scene::kDeep, RandomMotion(seed), 5, 5, 0, seed);  // any five pairs will do
    for (const Eigen::Matrix3d& E : SolveFivePoint(views.pairs)) {
      EXPECT_NEAR(E.norm(), std::sqrt(2.0), 1e-12);
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E);
      EXPECT_NEAR(svd.singularValues()[0], 1, 1e-3) << seed;
      EXPECT_NEAR(svd.singularValues()[2], 0, 1e-3) << seed;
      for (const PointPair& pair : views.pairs) EXPECT_LT(SampsonError2(E, pair), 1e-20);
    }
  }
}

TEST(FivePoint, EqualPairsAreNoTrouble) {
  for (const Eigen::Matrix3d& E : SolveFivePoint(std::vector<PointPair>(5, {{0.1, 0.2}, {0.1, 0.2}}))) {
    EXPECT_TRUE(E.allFinite());
  }
}

}  // namespace
}  // namespace gaitcam
