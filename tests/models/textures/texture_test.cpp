#include "models/code/textures/texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/pose.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

std::vector<std::string> GeneratedKinds() {
  std::vector<std::string> kinds = TextureKinds();
  kinds.erase(std::remove(kinds.begin(), kinds.end(), "image"), kinds.end());
  return kinds;
}

cv::Mat Make(const std::string& kind, uint64_t seed, Eigen::Vector2d size_m = {0, 0}, double px_per_m = 0) {
  TextureOptions options;
  options.kind = kind;
  options.seed = seed;
  options.size_m = size_m;
  options.px_per_m = px_per_m;
  return MakeTexture(CompleteTexture(options));
}

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::countNonZero(cv::Mat(a != b).reshape(1)) == 0;
}

cv::Mat Grey(const cv::Mat& bgr) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// Exponent of the amplitude spectrum: the slope of log amplitude over log frequency, between 1/50 and 0.3 cycles per
/// pixel (below, few waves fit in; above, anti-aliasing takes over). Hann window, mean over rings of 1/8 octave.
double SpectralSlope(const cv::Mat& bgr) {
  cv::Mat image, window, spectrum, planes[2], amplitude;
  Grey(bgr).convertTo(image, CV_32F);
  image -= cv::mean(image)[0];
  cv::createHanningWindow(window, image.size(), CV_32F);
  cv::dft(image.mul(window), spectrum, cv::DFT_COMPLEX_OUTPUT);
  cv::split(spectrum, planes);
  cv::magnitude(planes[0], planes[1], amplitude);
  constexpr double kLow = 0.02, kHigh = 0.3;
  const int rings = int(8 * std::log2(kHigh / kLow));
  std::vector<double> sum(rings, 0.0), count(rings, 0.0);
  for (int y = 0; y < amplitude.rows; ++y) {
    const double fy = double(std::min(y, amplitude.rows - y)) / amplitude.rows;
    for (int x = 0; x < amplitude.cols; ++x) {
      const double f = std::hypot(double(std::min(x, amplitude.cols - x)) / amplitude.cols, fy);
      if (f < kLow) continue;
      const int ring = int(8 * std::log2(f / kLow));
      if (ring >= rings) continue;
      sum[ring] += amplitude.at<float>(y, x);
      count[ring] += 1;
    }
  }
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int ring = 0; ring < rings; ++ring) {
    if (count[ring] < 1) continue;
    const double x = (ring + 0.5) / 8 * std::log(2), y = std::log(sum[ring] / count[ring]);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Kurtosis of differences between neighbours: 3 for Gaussian fields, far more for pictures of things with edges.
double DifferenceKurtosis(const cv::Mat& bgr) {
  cv::Mat image, diff, squared;
  Grey(bgr).convertTo(image, CV_64F);
  diff = image.colRange(1, image.cols) - image.colRange(0, image.cols - 1);
  diff -= cv::mean(diff)[0];
  squared = diff.mul(diff);
  const double variance = cv::mean(squared)[0];
  return cv::mean(squared.mul(squared))[0] / (variance * variance);
}

/// What a walking robot's camera sees of a floor that repeats: 320 x 240, 60 deg, 0.35 m high, 25 deg down.
cv::Mat RobotView(const cv::Mat& floor, const Eigen::Vector2d& size_m) {
  constexpr int kWidth = 320, kHeight = 240, kFiner = 3;  // finer, then averaged: as a pixel's area does
  const double f = 277.0 * kFiner;
  const Eigen::Matrix3d R = RotY(25 * M_PI / 180);  // x forward, y left, z up
  cv::Mat map_x(kHeight * kFiner, kWidth * kFiner, CV_32FC1), map_y(map_x.size(), CV_32FC1), fine, view;
  for (int v = 0; v < map_x.rows; ++v) {
    for (int u = 0; u < map_x.cols; ++u) {
      const Eigen::Vector3d ray = R * Eigen::Vector3d(1, -(u - map_x.cols / 2.0) / f, -(v - map_x.rows / 2.0) / f);
      const Eigen::Vector2d at = -0.35 / std::min(ray.z(), -1e-3) * ray.head<2>();
      const double column = at.x() / size_m.x() - std::floor(at.x() / size_m.x());
      const double row = at.y() / size_m.y() - std::floor(at.y() / size_m.y());
      map_x.at<float>(v, u) = float(column * floor.cols);
      map_y.at<float>(v, u) = float((1 - row) * floor.rows);
    }
  }
  cv::remap(floor, fine, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_WRAP);
  cv::resize(fine, view, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  return view;
}

/// Mean absolute differences between neighbouring columns; the last entry is across the seam.
std::vector<double> ColumnSteps(const cv::Mat& bgr) {
  std::vector<double> steps;
  for (int x = 0; x < bgr.cols; ++x) {
    cv::Mat diff;
    cv::absdiff(bgr.col(x), bgr.col((x + 1) % bgr.cols), diff);
    const cv::Scalar mean = cv::mean(diff);
    steps.push_back(mean[0] + mean[1] + mean[2]);
  }
  return steps;
}

TEST(Texture, EqualSeedsGiveEqualBitsAndOtherSeedsOtherPictures) {
  for (const std::string& kind : GeneratedKinds()) {
    const cv::Mat once = Make(kind, 7, {0.9, 0.7}, 200);
    EXPECT_TRUE(SameBits(once, Make(kind, 7, {0.9, 0.7}, 200))) << kind;
    EXPECT_FALSE(SameBits(once, Make(kind, 8, {0.9, 0.7}, 200))) << kind;
  }
}

TEST(Texture, TheNumberOfThreadsDoesNotMatter) {
  const int threads = cv::getNumThreads();
  for (const std::string& kind : GeneratedKinds()) {
    cv::setNumThreads(1);
    const cv::Mat one = Make(kind, 3, {1.1, 1.3}, 300);
    cv::setNumThreads(4);
    EXPECT_TRUE(SameBits(one, Make(kind, 3, {1.1, 1.3}, 300))) << kind;
  }
  cv::setNumThreads(threads);
}

TEST(Texture, EverySizeThatAFileMayAskForWorks) {
  for (const std::string& kind : GeneratedKinds()) {
    for (const auto& [size, px] :
         {std::pair(Eigen::Vector2d(0.02, 0.03), 100.0), std::pair(Eigen::Vector2d(5, 0.1), 90.0),
          std::pair(Eigen::Vector2d(0.1, 5), 90.0), std::pair(Eigen::Vector2d(1.3, 0.77), 333.0)}) {
      const cv::Mat picture = Make(kind, 1, size, px);
      EXPECT_EQ(picture.type(), CV_8UC3) << kind;
      EXPECT_GE(picture.cols, size.x() * px - 1) << kind;
      EXPECT_GE(picture.rows, size.y() * px - 1) << kind;
    }
  }
}

TEST(Texture, FloorsAndWallsRepeatWithoutASeam) {
  for (const char* kind : {"planks", "tiles", "terrazzo", "carpet", "concrete", "paint", "wood", "ceiling"}) {
    const cv::Mat across = Make(kind, 5, {1.5, 1.5}, 256);
    for (const cv::Mat& picture : {across, cv::Mat(across.t())}) {
      std::vector<double> steps = ColumnSteps(picture);
      const double seam = steps.back();
      steps.pop_back();
      // No step inside is smaller than the one across the seam by more than what differs from one joint to the next.
      EXPECT_LE(seam, 1.15 * *std::max_element(steps.begin(), steps.end())) << kind;
      if (std::string(kind) == "planks" || std::string(kind) == "tiles" || std::string(kind) == "ceiling") continue;
      // Without joints the seam must be like any other column; columns of 384 pixels scatter by a few percent, streaks
      // more.
      std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
      EXPECT_LE(seam, 1.5 * steps[steps.size() / 2]) << kind;
    }
  }
}

TEST(Texture, PostersHaveTheAmplitudeSpectrumOfNaturalImages) {
  for (const char* kind : {"dead_leaves", "pink", "poster"}) {
    double sum = 0;
    for (uint64_t seed = 1; seed <= 6; ++seed) sum += SpectralSlope(Make(kind, seed, {0.8, 0.8}, 640));
    // Photographs scatter around -1 by about 0.25 (Field 1987); printed text is flatter, so posters get more room.
    EXPECT_NEAR(sum / 6, -1.0, 0.25) << kind;
  }
}

TEST(Texture, DeadLeavesHaveEdgesAndPinkNoiseHasNone) {
  const double leaves = DifferenceKurtosis(Make("dead_leaves", 4)), pink = DifferenceKurtosis(Make("pink", 4));
  EXPECT_GT(leaves, 6);         // photographs: 6 to 30
  EXPECT_NEAR(pink, 3.0, 0.5);  // a sum of octaves of uniform noise: nearly Gaussian, its tails a little lighter
}

TEST(Texture, FloorsOfferFeaturesToARobotsCamera) {
  struct Bounds {
    const char* kind;
    int sift_low, sift_high, fast_low;
  };
  // From two thirds of what was measured (97/332, 112/336, 859/2274, 210/431, 134/390) to what would be noise, not
  // floor.
  for (const Bounds& bounds :
       {Bounds{"planks", 65, 500, 220}, Bounds{"tiles", 75, 500, 220}, Bounds{"terrazzo", 550, 1200, 1500},
        Bounds{"carpet", 140, 900, 280}, Bounds{"concrete", 90, 500, 260}}) {
    TextureOptions options;
    options.kind = bounds.kind;
    options.seed = 2;
    options = CompleteTexture(options);
    const cv::Mat view = Grey(RobotView(MakeTexture(options), options.size_m));
    std::vector<cv::KeyPoint> sift, fast;
    cv::SIFT::create()->detect(view, sift);
    cv::FAST(view, fast, 20);
    RecordProperty(std::string(bounds.kind) + "_sift", int(sift.size()));
    RecordProperty(std::string(bounds.kind) + "_fast", int(fast.size()));
    EXPECT_GE(int(sift.size()), bounds.sift_low) << bounds.kind;
    EXPECT_LE(int(sift.size()), bounds.sift_high) << bounds.kind;
    EXPECT_GE(int(fast.size()), bounds.fast_low) << bounds.kind;
  }
}

TEST(Texture, ContrastScalesWhatADetectorSees) {
  TextureOptions faint;
  faint.kind = "concrete";
  faint = CompleteTexture(faint);
  faint.contrast = 0.2;
  TextureOptions usual = faint;
  usual.contrast = 1;
  cv::Scalar mean, faint_sigma, usual_sigma;
  cv::meanStdDev(MakeTexture(faint), mean, faint_sigma);
  cv::meanStdDev(MakeTexture(usual), mean, usual_sigma);
  EXPECT_NEAR(faint_sigma[1] / usual_sigma[1], 0.2, 0.02);  // rounding to 8 bit and saturation
}

TEST(Texture, SurfacesAreNeitherBurntOutNorBlack) {
  for (const std::string& kind : GeneratedKinds()) {
    const cv::Mat grey = Grey(Make(kind, 9));
    const double mean = cv::mean(grey)[0];
    EXPECT_GT(mean, 40) << kind;
    EXPECT_LT(mean, 230) << kind;
    EXPECT_LT(cv::countNonZero(grey >= 253), 0.06 * double(grey.total()))
        << kind;  // books and lamps are white in parts
    EXPECT_LT(cv::countNonZero(grey <= 3), 0.06 * double(grey.total())) << kind;
  }
}

TEST(Texture, TheFieldsLinesLieWhereTheRulesSay) {
  TextureOptions options;
  options.kind = "field";
  options = CompleteTexture(options);
  const cv::Mat field = MakeTexture(options);
  const auto at = [&](double x, double y) {
    return field.at<cv::Vec3b>(int((0.5 - y / options.size_m.y()) * field.rows),
                               int((0.5 + x / options.size_m.x()) * field.cols));
  };
  const auto is_white = [&](double x, double y) { return at(x, y)[0] > 150 && at(x, y)[2] > 150; };
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(is_white(side * 2.7, 0.2));  // goal lines of the 5.4 m
    EXPECT_TRUE(is_white(0.5, side * 1.8));  // side lines of the 3.6 m
    EXPECT_TRUE(is_white(0.0, side * 1.0));  // the middle line
    EXPECT_TRUE(is_white(side * 0.6, 0.0));  // the centre circle
    EXPECT_FALSE(is_white(side * 1.7, 0.9));
    EXPECT_FALSE(is_white(side * 3.0, 0.0));
  }
}

TEST(Texture, AUsersPictureIsShownAsItIs) {
  const TemporaryFolder folder;
  cv::Mat picture(20, 30, CV_8UC3, cv::Scalar(10, 20, 30));
  picture.at<cv::Vec3b>(3, 4) = {200, 100, 50};
  cv::imwrite((folder.path() / "texture_test.png").string(), picture);
  TextureOptions options;
  options.kind = "image";
  options.file = "texture_test.png";
  EXPECT_TRUE(SameBits(MakeTexture(CompleteTexture(options), folder.path()), picture));
}

std::string TextureError(const TextureOptions& options, const std::filesystem::path& folder = {}) {
  try {
    MakeTexture(CompleteTexture(options), folder);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "";
}

TEST(Texture, WhatCannotBeMadeIsNamed) {
  TextureOptions options;
  options.kind = "plank";
  EXPECT_THAT(TextureError(options), testing::HasSubstr("kind: \"plank\" is not permitted"));
  options.kind = "planks";
  options.size_m = {1, -1};
  EXPECT_THAT(TextureError(options), testing::HasSubstr("size_m: [1, -1] is not permitted"));
  options.size_m = {100, 100};
  options.px_per_m = 1000;
  EXPECT_THAT(TextureError(options), testing::HasSubstr("px_per_m: 1000 gives 10000 million pixels"));
  options = {};
  options.rgb = {0.5, 0.5, 1.5};
  EXPECT_THAT(TextureError(options), testing::HasSubstr("rgb: expected three numbers from 0 to 1"));
  options = {};
  options.kind = "image";
  EXPECT_THAT(TextureError(options), testing::HasSubstr("file: missing"));
  options.file = "no_such_picture.png";
  EXPECT_THAT(TextureError(options, "/somewhere"),
              testing::HasSubstr("/somewhere/no_such_picture.png: no such picture file"));
  const TemporaryFolder folder;
  options.file = folder.Write("texture_test.txt", "not a picture").string();
  EXPECT_THAT(TextureError(options), testing::HasSubstr("not a picture that can be read"));
}

}  // namespace
}  // namespace gaitcam
