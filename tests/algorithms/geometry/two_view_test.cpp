#include "algorithms/geometry/two_view.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <opencv2/calib3d.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/relative_pose/methods.hpp>
#include <opengv/sac/Ransac.hpp>
#include <opengv/sac_problems/relative_pose/CentralRelativePoseSacProblem.hpp>

#include "algorithms/core/se3.h"
#include "tests/algorithms/geometry/view_pairs.h"

namespace gaitcam {
namespace {

RansacOptions TwoViewOptions(double threshold_px) {
  RansacOptions options;
  options.threshold = threshold_px / kFocalPx;
  return options;
}

TEST(TwoView, ExactPairsGiveTheExactPose) {
  const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), 60, 0, 0, 1);
  RandomStream random(1, "ransac");
  const TwoView result = EstimateTwoView(views.pairs, TwoViewOptions(1), random);
  EXPECT_EQ(result.inliers.size(), 60u);
  EXPECT_LT(RotationAngle(result.X_AB.rotation, views.X_AB.rotation), 1e-7);
  EXPECT_LT(DirectionError(result.X_AB, views.X_AB), 1e-6);
  EXPECT_NEAR(result.X_AB.translation.norm(), 1, 1e-12);
}

TEST(TwoView, OutliersAreFoundOutAndNoiseIsAveraged) {
  int good_kept = 0, good = 0, bad_kept = 0, bad = 0;
  std::vector<double> turn, direction, clean_turn, clean_direction;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), 150, 50, 0.5, seed);
    RandomStream random(seed, "ransac");
    const TwoView result = EstimateTwoView(views.pairs, TwoViewOptions(2), random);
    const std::vector<PointPair> clean_pairs(views.pairs.begin(), views.pairs.begin() + 100);
    const TwoView clean = EstimateTwoView(clean_pairs, TwoViewOptions(2), random);
    turn.push_back(RotationAngle(result.X_AB.rotation, views.X_AB.rotation));
    direction.push_back(DirectionError(result.X_AB, views.X_AB));
    clean_turn.push_back(RotationAngle(clean.X_AB.rotation, views.X_AB.rotation));
    clean_direction.push_back(DirectionError(clean.X_AB, views.X_AB));
    EXPECT_LT(turn.back(), 0.02) << seed;
    EXPECT_LT(direction.back(), 0.06) << seed;
    good += 100;
    bad += 50;
    for (const int i : result.inliers) ++(i < 100 ? good_kept : bad_kept);
  }
  // What the hundred true pairs alone allow, and half as much again for false ones that lie on their lines by chance.
  EXPECT_LT(UpperMedian(turn), 1.5 * UpperMedian(clean_turn));
  EXPECT_LT(UpperMedian(direction), 1.5 * UpperMedian(clean_direction));
  EXPECT_GT(good_kept, 0.95 * good);
  EXPECT_LT(bad_kept, 0.1 * bad);  // a random pair lies within 2 px of its epipolar line by chance
}

TEST(TwoView, ItsOwnErrorBarIsHonest) {
  // Over many noise draws the direction's error must be what direction_sigma says along the worst of its two axes.
  double error2 = 0, sigma2 = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), 120, 0, 0.3, seed);
    RandomStream random(seed, "ransac");
    const TwoView result = EstimateTwoView(views.pairs, TwoViewOptions(2), random);
    const double error = DirectionError(result.X_AB, views.X_AB);
    error2 += error * error / 60;
    sigma2 += result.direction_sigma * result.direction_sigma / 60;
  }
  // The error has two axes, of which sigma is the worse one: the ratio lies between 1 and 2, give or take the scatter
  // of 60 draws (20 %).
  EXPECT_GT(error2 / sigma2, 0.75);
  EXPECT_LT(error2 / sigma2, 2.5);
}

TEST(TwoView, ATurnOnTheSpotShowsNoParallax) {
  const ViewPairs views = MakeViewPairs(Scene::kDeep, Pose(RotY(0.15), Eigen::Vector3d::Zero()), 100, 0, 0.3, 3);
  RandomStream random(3, "ransac");
  const TwoView result = EstimateTwoView(views.pairs, TwoViewOptions(2), random);
  EXPECT_LT(RotationAngle(result.X_AB.rotation, views.X_AB.rotation), 0.01);
  EXPECT_LT(result.parallax, 0.005);
  EXPECT_GT(result.direction_sigma, 0.1);
}

Pose OpenCvPose(const ViewPairs& views, double threshold) {
  std::vector<cv::Point2d> a, b;
  for (const PointPair& pair : views.pairs) {
    a.emplace_back(pair.a.x(), pair.a.y());
    b.emplace_back(pair.b.x(), pair.b.y());
  }
  cv::theRNG().state = 1;
  cv::Mat inliers, R, t;
  const cv::Mat E = cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.9999, threshold, inliers);
  if (E.rows != 3) return Pose(Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX());
  cv::recoverPose(E, a, b, cv::Mat::eye(3, 3, CV_64F), R, t, inliers);
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = R.at<double>(i / 3, i % 3);
  return Pose(rotation, {t.at<double>(0), t.at<double>(1), t.at<double>(2)}).Inverse();
}

// RANSAC over its five-point solver, then its non-linear optimisation over the inliers.
Pose OpenGvPose(const ViewPairs& views, double threshold) {
  opengv::bearingVectors_t a, b;
  for (const PointPair& pair : views.pairs) {
    a.push_back(pair.a.homogeneous().normalized());
    b.push_back(pair.b.homogeneous().normalized());
  }
  using Problem = opengv::sac_problems::relative_pose::CentralRelativePoseSacProblem;
  opengv::relative_pose::CentralRelativeAdapter adapter(a, b);
  const auto problem = std::make_shared<Problem>(adapter, Problem::NISTER, false);
  opengv::sac::Ransac<Problem> ransac;
  ransac.sac_model_ = problem;
  ransac.threshold_ = 2 * (1 - std::cos(std::atan(threshold)));  // its residual adds those of both views
  ransac.max_iterations_ = 300;
  ransac.computeModel();
  opengv::transformation_t refined = ransac.model_coefficients_;
  problem->optimizeModelCoefficients(ransac.inliers_, ransac.model_coefficients_, refined);
  return Pose(Eigen::Matrix3d(refined.leftCols<3>()), refined.col(3));
}

struct Comparison {
  const char* name;
  Scene scene;
  int outliers;
  double noise_px;
  bool turn_only;
};

class AgainstPeers : public testing::TestWithParam<Comparison> {};

// For each estimator the median errors over many scenes are at most those of OpenCV and OpenGV.
TEST_P(AgainstPeers, NoLessAccurateInTheMedian) {
  const Comparison& c = GetParam();
  constexpr int kScenes = 40;
  constexpr double kThreshold = 2 / kFocalPx;
  std::vector<double> opencv_R, opencv_t, opengv_R, opengv_t;
  std::vector<ViewPairs> scenes;
  for (uint64_t seed = 0; seed < kScenes; ++seed) {
    Pose X_AB = RandomMotion(seed);
    if (c.turn_only) X_AB.translation.setZero();
    scenes.push_back(MakeViewPairs(c.scene, X_AB, 200, c.outliers, c.noise_px, seed));
    const Pose opencv = OpenCvPose(scenes.back(), kThreshold), opengv_ = OpenGvPose(scenes.back(), kThreshold);
    opencv_R.push_back(RotationAngle(opencv.rotation, X_AB.rotation));
    opengv_R.push_back(RotationAngle(opengv_.rotation, X_AB.rotation));
    opencv_t.push_back(c.turn_only ? 0 : DirectionError(opencv, X_AB));
    opengv_t.push_back(c.turn_only ? 0 : DirectionError(opengv_, X_AB));
  }
  for (const auto& [kind, estimator] : WordsOf(RobustEstimator())) {
    std::vector<double> R, t;
    int verdicts = 0, planes = 0, among = 0;
    for (const ViewPairs& views : scenes) {
      RansacOptions options = TwoViewOptions(2);
      options.estimator = kind;
      RandomStream random(1, "peers");
      const TwoView found = EstimateTwoView(views.pairs, options, random);
      R.push_back(RotationAngle(found.X_AB.rotation, views.X_AB.rotation));
      t.push_back(c.turn_only ? 0 : DirectionError(found.X_AB, views.X_AB));
      verdicts += found.rotation_only;
      planes += found.planar;
      among += t.back() < 0.15 || (found.alternative && DirectionError(*found.alternative, views.X_AB) < 0.15);
    }
    printf(
        "%-10s %-10s rotation, direction (mrad): %6.2f %6.2f   OpenCV %6.2f %6.2f   OpenGV %6.2f %6.2f   turn %d plane "
        "%d among %d\n",
        c.name, estimator.data(), 1e3 * UpperMedian(R), 1e3 * UpperMedian(t), 1e3 * UpperMedian(opencv_R),
        1e3 * UpperMedian(opencv_t), 1e3 * UpperMedian(opengv_R), 1e3 * UpperMedian(opengv_t), verdicts, planes, among);
    EXPECT_LE(UpperMedian(R), std::min(UpperMedian(opencv_R), UpperMedian(opengv_R))) << estimator;
    EXPECT_LE(UpperMedian(t), std::min(UpperMedian(opencv_t), UpperMedian(opengv_t))) << estimator;
    EXPECT_EQ(verdicts, c.turn_only ? kScenes : 0) << estimator;
    if (!c.turn_only) {
      EXPECT_EQ(planes > kScenes / 2, c.scene == Scene::kPlane) << estimator;
      EXPECT_GE(among, kScenes * 0.95) << estimator;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, AgainstPeers,
                         testing::Values(Comparison{"Noise", Scene::kDeep, 0, 0.5, false},
                                         Comparison{"Outliers", Scene::kDeep, 60, 0.5, false},
                                         Comparison{"Plane", Scene::kPlane, 20, 0.5, false},
                                         Comparison{"Turn", Scene::kDeep, 20, 0.5, true}),
                         [](const auto& info) { return info.param.name; });

/// Floor 1.3 m below a camera that looks ahead and a little down, and goes ahead; a few points high on a wall behind.
ViewPairs FloorAhead(uint64_t seed) {
  RandomStream random(seed, "floor");
  const Eigen::Vector3d up(0, -std::cos(0.2), -std::sin(0.2));
  ViewPairs views;
  views.X_AB = Pose(ExpSo3({0.01 * random.Normal(), 0.03 * random.Normal(), 0}),
                    {random.Uniform(-0.1, 0.1), random.Uniform(-0.02, 0.02), 0.35});
  const auto noisy = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    return p.hnormalized() + Eigen::Vector2d(random.Normal(), random.Normal()) * 0.3 / kFocalPx;
  };
  for (int i = 0; i < 200; ++i) {
    const bool on_wall = i % 10 == 0;
    Eigen::Vector3d p_A(random.Uniform(-2, 2), 0, random.Uniform(2, 6));
    p_A.y() = (1.3 + up.z() * p_A.z()) / -up.y();  // up . p_A = -1.3
    if (on_wall) p_A = {random.Uniform(-3, 3), random.Uniform(-3, -1), 12};
    views.pairs.push_back({noisy(p_A), noisy(views.X_AB.Inverse() * p_A)});
  }
  return views;
}

TEST(TwoView, GravitySettlesWhichOfAFloorsTwoMotionsIsTrue) {
  const Eigen::Vector3d up_A(0, -std::cos(0.3), -std::sin(0.3));  // 6 degrees wrong, as a walker's pitch may be
  constexpr double kThreshold = 2 / kFocalPx;
  int without_certain_and_right = 0, certain = 0;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const ViewPairs views = FloorAhead(seed);
    RandomStream random(seed, "ransac");
    const auto found = EstimateEssential(views.pairs, TwoViewOptions(2), random, SampsonError2);
    const TwoView without = RefineTwoView(views.pairs, found.model, found.inliers, kThreshold);
    const TwoView with = RefineTwoView(views.pairs, found.model, found.inliers, kThreshold, up_A);
    without_certain_and_right += !without.alternative && DirectionError(without.X_AB, views.X_AB) < 0.15;
    certain += !with.alternative;
    if (with.alternative) continue;  // it says that it does not know
    EXPECT_LT(DirectionError(with.X_AB, views.X_AB), 0.15) << seed << ": the other motion is some 1.5 rad away";
  }
  EXPECT_GE(certain, 25) << "of 30";
  EXPECT_GT(certain, without_certain_and_right);
}

TEST(TwoView, WithoutEnoughToGoByThereIsNoPose) {
  RandomStream random(1, "ransac");
  EXPECT_TRUE(EstimateTwoView({}, TwoViewOptions(1), random).inliers.empty());
  EXPECT_TRUE(EstimateTwoView(MakeViewPairs(Scene::kDeep, SomeMotion(), 7, 0, 0, 1).pairs, TwoViewOptions(1), random)
                  .inliers.empty());
  const std::vector<PointPair> same(50, {{0.1, 0.2}, {0.1, 0.2}});
  const TwoView result = EstimateTwoView(same, TwoViewOptions(1), random);
  EXPECT_TRUE(result.X_AB.Matrix().allFinite());
  EXPECT_TRUE(std::isfinite(result.parallax) && std::isfinite(result.direction_sigma));
}

TEST(TwoView, SameSeedSameBits) {
  const ViewPairs views = MakeViewPairs(Scene::kDeep, SomeMotion(), 100, 30, 0.5, 1);
  RandomStream a(7, "ransac"), b(7, "ransac");
  const TwoView first = EstimateTwoView(views.pairs, TwoViewOptions(2), a);
  cv::theRNG().state = 99;
  const TwoView second = EstimateTwoView(views.pairs, TwoViewOptions(2), b);
  EXPECT_EQ(first.X_AB.translation, second.X_AB.translation);
  EXPECT_EQ(first.X_AB.rotation.coeffs(), second.X_AB.rotation.coeffs());
  EXPECT_EQ(first.inliers, second.inliers);
}

}  // namespace
}  // namespace gaitcam
