#include "scenarios/code/experiments/feature_experiment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "scenarios/code/experiments/blur_kernels.h"
#include "scenarios/code/experiments/feature_table.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

const std::filesystem::path kPictures = "/usr/share/doc/opencv-doc/examples/data";

TEST(FeatureExperiment, LineKernelIsALineThroughItsMiddle) {
  const LineBlur blur{17.3, 0.7};
  const cv::Mat kernel = LineKernel(blur);
  double sum = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (int y = 0; y < kernel.rows; ++y)
    for (int x = 0; x < kernel.cols; ++x) {
      const Eigen::Vector2d p(x - kernel.cols / 2, y - kernel.rows / 2);
      const double w = kernel.at<float>(y, x);
      sum += w;
      mean += w * p;
      scatter += w * p * p.transpose();
    }
  EXPECT_NEAR(sum, 1, 1e-5);
  EXPECT_NEAR(mean.norm(), 0, 1e-4);
  const Eigen::Vector2d along(std::cos(0.7), std::sin(0.7));
  // A line's variance is extent^2 / 12; sharing light among four pixels adds less than 1/4 on either axis.
  EXPECT_NEAR(along.dot(scatter * along), 17.3 * 17.3 / 12, 0.25);
  EXPECT_LT(along.unitOrthogonal().dot(scatter * along.unitOrthogonal()), 0.25);
}

TEST(FeatureExperiment, FilmingASharpImageOnlyCrops) {
  cv::Mat grey(120, 160, CV_8UC1);
  cv::randu(grey, 0, 256);
  const cv::Mat filmed = FilmBlurred(grey, {}, {"clean", false, 0, 0}, 1);
  EXPECT_EQ(cv::norm(filmed, grey(cv::Rect(kCrop_px, kCrop_px, 160 - 2 * kCrop_px, 120 - 2 * kCrop_px)), cv::NORM_INF),
            0);
}

TEST(FeatureExperiment, BlurInLightBrightensWhatIsDarkBesideBright) {
  cv::Mat edge(120, 160, CV_8UC1, cv::Scalar(0));
  edge.colRange(80, 160) = 255;
  const auto at_edge = [&](bool linear) {
    return int(FilmBlurred(edge, {20, 0}, {"", linear, 0, 0}, 1).at<uchar>(30, 80 - kCrop_px));
  };
  EXPECT_NEAR(at_edge(false), 0.525 * 255, 4);  // half the light, and half a pixel
  EXPECT_NEAR(at_edge(true), std::pow(0.525, 1 / 2.2) * 255, 4);
}

TEST(FeatureExperiment, NoiseHasItsSigmaAndComesFromTheSeed) {
  const cv::Mat grey(200, 200, CV_8UC1, cv::Scalar(100));
  const CameraSetting setting{"noise", false, 2, 0};
  const cv::Mat a = FilmBlurred(grey, {}, setting, 1), again = FilmBlurred(grey, {}, setting, 1);
  cv::Scalar mean, sigma;
  cv::meanStdDev(a, mean, sigma);
  EXPECT_NEAR(sigma[0], std::sqrt(4 + 1.0 / 12), 0.05);  // rounding adds 1/12; 23000 samples
  EXPECT_EQ(cv::norm(a, again, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a, FilmBlurred(grey, {}, setting, 2), cv::NORM_INF), 0);
}

/// Features at given places whose descriptors are unit vectors of given axes.
Features Points(const std::vector<std::pair<cv::Point2f, int>>& points) {
  Features features;
  features.descriptors = cv::Mat::zeros(int(points.size()), 16, CV_32FC1);
  for (size_t i = 0; i < points.size(); ++i) {
    features.keypoints.emplace_back(points[i].first, 1.f);
    features.descriptors.at<float>(int(i), points[i].second) = 1;
  }
  return features;
}

TEST(FeatureExperiment, CountsCorrectMatchesWithoutDuplicates) {
  const Features a = Points({{{10, 10}, 0}, {{10, 10}, 0}, {{20, 10}, 1}, {{30, 10}, 2}});
  const Features b = Points({{{11, 12}, 0}, {{20, 14}, 1}, {{31, 10}, 2}, {{90, 90}, 3}});
  const std::vector<MatchCount> counts = CountMatches(a, b, MapOfHomography(Eigen::Matrix3d::Identity()), {0.8});
  EXPECT_EQ(counts[0].matches, 3);  // the first two are one
  EXPECT_EQ(counts[0].correct, 2);  // the third is 4 px off
  EXPECT_NEAR(counts[0].MedianError(), std::sqrt(5), 1e-5);
}

TEST(FeatureExperiment, CountsNothingWhereTheTruthIsUnknown) {
  const Features a = Points({{{10, 10}, 0}, {{20, 10}, 1}}), b = a;
  const TrueMap left_half = [](const Eigen::Vector2d& p) -> std::optional<Eigen::Vector2d> {
    if (p.x() > 15) return std::nullopt;
    return p;
  };
  const std::vector<MatchCount> counts = CountMatches(a, b, left_half, {0.8});
  EXPECT_EQ(counts[0].matches, 1);
  EXPECT_EQ(counts[0].correct, 1);
}

TEST(FeatureExperiment, AGeneratedPairObeysItsHomography) {
  const std::vector<ImagePair> pairs = MakePairs({kPictures / "home.jpg"}, 3);
  ASSERT_EQ(pairs.size(), 1u);
  const Features a = DetectFeatures(*MakeFeature2d("sift"), pairs[0].a, 2000);
  const Features b = DetectFeatures(*MakeFeature2d("sift"), pairs[0].b, 2000);
  const MatchCount count = CountMatches(a, b, MapOfHomography(pairs[0].H_ba), {0.6}).front();
  EXPECT_GT(count.correct, 100);
  EXPECT_GT(count.Precision(), 0.9);
  EXPECT_LT(count.MedianError(), 0.5);
}

TEST(FeatureExperiment, TheWholeOfItOnOneSmallPair) {
  ImagePair pair = MakePairs({kPictures / "home.jpg"}, 3).front();
  pair.a = pair.a(cv::Rect(100, 60, 300, 240)).clone();
  pair.b = pair.b(cv::Rect(100, 60, 300, 240)).clone();
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = Eigen::Vector2d(100, 60);
  pair.H_ba = shift.inverse() * pair.H_ba * shift;
  FeatureExperimentOptions options;
  options.detectors = {"sift", "mobif_fast"};
  options.extents_px = {0, 20};
  const std::vector<FeatureCell> cells = RunFeatureExperiment({pair}, options, [](int, int) {});
  const auto correct = [&](const std::string& detector, double extent) {
    for (const FeatureCell& c : cells)
      if (c.detector == detector && c.setting == "clean" && c.extent_px == extent && !c.both && c.ratio == 0.8)
        return c.count.correct;
    return -1;
  };
  EXPECT_GT(correct("sift", 0), 5 * correct("sift", 20));
  EXPECT_GT(correct("mobif_fast", 20), 2 * correct("sift", 20));
  EXPECT_EQ(cells.size(), 2u * 3 * 2 * 3);  // detectors, settings, ratios; sharp, one and both
  const std::string table = FeatureTable(cells, {}, {"home"}, "gaitcam experiment features");
  EXPECT_NE(table.find("| mobif_fast |"), std::string::npos);
  EXPECT_FALSE(FeaturePlot(cells).empty());
}

/// A part of a photograph, 300 x 240 px, paired with itself.
ImagePair SmallPictureWithItself() {
  ImagePair pair;
  pair.name = "itself";
  pair.H_ba = Eigen::Matrix3d::Identity();
  pair.a = pair.b = MakePairs({kPictures / "home.jpg"}, 3).front().a(cv::Rect(100, 60, 300, 240)).clone();
  return pair;
}

TEST(FeatureExperiment, EqualNumbersAreEqualWhereADetectorFindsFewByItself) {
  const ImagePair pair = SmallPictureWithItself();
  FeatureExperimentOptions options;
  options.detectors = {"sift", "surf", "mobif_fast"};
  options.extents_px = {20};
  const auto fewest = [&](int strongest) {
    options.strongest = strongest;
    std::set<int> numbers;
    for (const FeatureCell& cell : RunFeatureExperiment({pair}, options, [](int, int) {}))
      if (cell.setting == "clean") numbers.insert(cell.count.fewest_points);
    return numbers;
  };
  EXPECT_EQ(fewest(40), std::set<int>{40});
  EXPECT_LT(*fewest(0).begin(), 40);
  options.strongest = 40;
  options.detectors = {"sift_single"};
  EXPECT_THROW(RunFeatureExperiment({pair}, options, [](int, int) {}), BadInput);
}

// Most entropies lie within a standard deviation of their mean: a sixth or so is below.
TEST(FeatureExperiment, FeaturesOfLowEntropyAreInOneOfTwoDetectorsAlike) {
  const ImagePair pair = SmallPictureWithItself();
  FeatureExperimentOptions options;
  options.detectors = {"mobif", "mobif_discards", "mobif_adapt_all", "mobif_adapt"};
  options.extents_px = {0};
  std::map<std::string, int> right;
  for (const FeatureCell& cell : RunFeatureExperiment({pair}, options, [](int, int) {})) {
    if (cell.setting == "clean" && cell.ratio == 0.8) right[cell.detector] = cell.count.correct;
  }
  for (const auto& [all, some] : {std::pair{"mobif", "mobif_discards"}, {"mobif_adapt_all", "mobif_adapt"}}) {
    EXPECT_GT(right[some], 0.6 * right[all]) << some;
    EXPECT_LT(right[some], 0.95 * right[all]) << some;
  }
}

TEST(FeatureExperiment, KernelsOfAWalkOnOneSmallPair) {
  ImagePair pair = MakePairs({kPictures / "home.jpg"}, 3).front();
  pair.a = pair.b = pair.a(cv::Rect(100, 60, 300, 240)).clone();
  pair.H_ba = Eigen::Matrix3d::Identity();
  KernelExperimentOptions options;
  options.kinds = {BlurKind::kRamp};
  options.extents_px = {16};
  options.settings = {"noise"};
  const std::vector<KernelTrial> trials = RunKernelExperiment({pair}, options, [](int, int) {});
  ASSERT_EQ(trials.size(), 2u);  // sharp, and the ramp
  const std::vector<std::string> ways = KernelWays();
  const auto correct = [&](const KernelTrial& trial, const std::string& way) {
    return trial.ways[size_t(std::find(ways.begin(), ways.end(), way) - ways.begin())].correct;
  };
  for (const KernelTrial& trial : trials) {
    if (trial.extent_px == 0) continue;
    EXPECT_GT(correct(trial, "mobif, path known"), 3 * correct(trial, "sift")) << int(trial.kind);
  }
  const std::string table = KernelTable(trials, "gaitcam experiment features --kernels");
  EXPECT_NE(table.find("| ramp | 16 px |"), std::string::npos);
  EXPECT_NE(table.find("| mobif, path known to 1 px |"), std::string::npos);
  EXPECT_NE(table.find("## Confidence"), std::string::npos);
}

TEST(FeatureExperiment, PairsOfAWalkAreCountedByTheirBlurAndAgainstSiftPairByPair) {
  const cv::Mat sharp = cv::imread((kPictures / "home.jpg").string(), cv::IMREAD_GRAYSCALE)(cv::Rect(80, 40, 320, 240));
  const auto filmed = [&](double extent_px) { return FilmBlurred(sharp, {extent_px, 0.4}, {"", false, 0, 0}, 1); };
  const auto still = [](const Eigen::Vector2d& pixel) { return std::optional(pixel); };
  const std::vector<WalkPair> pairs = {{filmed(0), filmed(16), still, 16},
                                       {filmed(0), filmed(0), still, 2},
                                       {filmed(0), cv::Mat(192, 272, CV_8UC1, cv::Scalar(90)), still, 15}};
  FeatureExperimentOptions options;
  options.detectors = {"mobif_fast", "sift"};
  const std::vector<WalkCell> cells = RunWalkExperiment(pairs, options, [](int, int) {});
  ASSERT_EQ(cells.size(), 4u);  // no pair lies from 3 to 15 px
  const WalkCell &ours = cells[2], &sift = cells[3];
  EXPECT_EQ(ours.from_px, 15);
  EXPECT_EQ(ours.pairs, 2);
  EXPECT_GT(ours.count.correct, 3 * sift.count.correct);
  EXPECT_EQ(ours.more_than_sift, 1);  // nothing is found in a grey picture by either
  EXPECT_FALSE(sift.more_than_sift);
  EXPECT_EQ(cells[1].pairs, 1);
  EXPECT_EQ(cells[1].count.Precision(), 1);  // the same picture twice
  const std::string table = FeatureTable({}, cells, {}, "gaitcam experiment features --walk-alone");
  EXPECT_NE(table.find("| 15 px and more | 2 | mobif_fast |"), std::string::npos) << table;
  EXPECT_EQ(table.find("Image pairs"), std::string::npos);
}

TEST(FeatureExperiment, SaysWhatIsWrongWithAFolder) {
  const TemporaryFolder folder;
  EXPECT_THROW(ReadPairs(folder.path()), BadInput);
  cv::imwrite((folder.path() / "img1.png").string(), cv::Mat(50, 50, CV_8UC1, cv::Scalar(0)));
  cv::imwrite((folder.path() / "img2.png").string(), cv::Mat(50, 50, CV_8UC1, cv::Scalar(0)));
  std::ofstream(folder.path() / "H1to2p") << "1 0 0 0 1";
  EXPECT_THROW(ReadPairs(folder.path()), BadInput);
  std::ofstream(folder.path() / "H1to2p") << "1 0 5 0 1 0 0 0 1";
  const std::vector<ImagePair> pairs = ReadPairs(folder.path());
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].H_ba(0, 2), 5);
  FeatureExperimentOptions options;
  options.detectors = {"shift"};
  EXPECT_THROW(RunFeatureExperiment(pairs, options, [](int, int) {}), BadInput);
}

}  // namespace
}  // namespace gaitcam
