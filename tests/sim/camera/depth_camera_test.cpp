#include "sim/camera/depth_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "sim/camera/lens.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// 320 x 240 px, 60 degrees wide: a focal length of 277 px.
class DepthCameraTest : public testing::Test {
 protected:
  /// @param nearness 1/z at ray (x, y); 0: nothing.
  cv::Mat See(const std::function<double(double x, double y)>& nearness) const {
    cv::Mat depth(camera_.height_px, camera_.width_px, CV_32FC1, cv::Scalar(0));
    for (int v = 0; v < depth.rows; ++v) {
      for (int u = 0; u < depth.cols; ++u) {
        const cv::Vec2f& ray = rays().at<cv::Vec2f>(v, u);
        if (const double w = nearness(ray[0], ray[1]); w > 0) depth.at<float>(v, u) = float(1 / w);
      }
    }
    return depth;
  }
  cv::Mat Measure(DepthModel model, const cv::Mat& depth, int grey = 188, uint64_t seed = 1) const {
    const cv::Mat image(depth.size(), CV_8UC3, cv::Scalar::all(grey));
    return MeasureDepth(model, depth, rays(), image, RandomStream(seed, "depth"));
  }
  const cv::Mat& rays() const { return lens_.rays(); }

  /// Root mean square of what was read against the truth, and the part of the pixels without a reading.
  struct Errors {
    double rms_m = 0, holes = 0;
  };
  static Errors Compare(const cv::Mat& measured, const cv::Mat& truth) {
    const cv::Rect inside(1, 1, truth.cols - 2, truth.rows - 2);  // the outermost pixels' slant is not known
    Errors errors;
    double read = 0;
    for (int v = 0; v < inside.height; ++v) {
      for (int u = 0; u < inside.width; ++u) {
        const double z = double(measured(inside).at<float>(v, u)), d = z - double(truth(inside).at<float>(v, u));
        if (z == 0) continue;
        errors.rms_m += d * d;
        ++read;
      }
    }
    return {std::sqrt(errors.rms_m / read), 1 - read / double(inside.area())};
  }

  CameraModel camera_ = CameraModel::FromHorizontalFov(320, 240, 60);
  Lens lens_{camera_};
};

TEST_F(DepthCameraTest, StructuredLightSpreadsAsPublishedOnAWall) {
  for (const double z : {1.0, 2.0, 4.0}) {
    // The wall leans: its disparities then lie anywhere between two steps, as the formula takes them to.
    const cv::Mat truth = See([&](double x, double) { return (1 + 0.3 * x) / z; });
    const cv::Mat measured = Measure(DepthModel::kStructuredLight, truth);
    EXPECT_EQ(Compare(measured, truth).holes, 0) << z;
    const double rounding_m = 1e-3 / std::sqrt(12);
    double by_paper = 0, by_data_sheet = 0, mean = 0, count = 0;
    for (int v = 1; v < 239; ++v) {
      for (int u = 1; u < 319; ++u, ++count) {
        const double true_z = double(truth.at<float>(v, u)), error = double(measured.at<float>(v, u)) - true_z;
        const double published_m = 1e-2 * 1.425e-5 * std::pow(100 * true_z, 2);
        by_paper += std::pow(error, 2) / (std::pow(published_m, 2) + std::pow(rounding_m, 2));
        by_data_sheet += std::pow(error / DepthDataSheet(DepthModel::kStructuredLight).Sigma(true_z), 2);
        mean += error / published_m;
      }
    }
    // 76000 readings, of which windows of 5 x 5 px share their noise, tell a spread to 1 / sqrt(2 * 3000) = 1.3 %; two
    // of that, and the paper's figure is rounded: half a step is 0.8 % more.
    EXPECT_NEAR(std::sqrt(by_paper / count), 1, 0.035) << z;
    EXPECT_NEAR(std::sqrt(by_data_sheet / count), 1, 0.035) << z;
    // Of second order: E[1/d] is above 1 / E[d] by sigma / d of the spread, at 4 m 0.6 %; and that rounding.
    EXPECT_NEAR(mean / count, 0, 0.05) << z;
  }
}

TEST_F(DepthCameraTest, NeighboursShareTheNoiseOfStructuredLightAsTheirWindowsOverlap) {
  const cv::Mat truth = See([](double x, double) { return (1 + 0.3 * x) / 4; });
  const cv::Mat measured = Measure(DepthModel::kStructuredLight, truth);
  const auto correlation = [&](int shift) {
    double product = 0, square = 0;
    for (int v = 1; v < 239; ++v) {
      for (int u = 1; u < 319 - shift; ++u) {
        const auto error = [&](int at) {
          const double z = double(truth.at<float>(v, at));
          return (double(measured.at<float>(v, at)) - z) / (z * z);
        };
        product += error(u) * error(u + shift);
        square += error(u) * error(u);
      }
    }
    return product / square;
  };
  // Windows of 9 px at a focal length of 580 px are 5 px here; of the variance, rounding to steps has a third, of its
  // own in each pixel: (1 - shift / 5) * 2 / 3. Known to 1 / sqrt(3000) = 2 %, and roundings are not quite independent.
  EXPECT_NEAR(correlation(1), 0.8 * 2 / 3, 0.06);
  EXPECT_NEAR(correlation(3), 0.4 * 2 / 3, 0.06);
  EXPECT_NEAR(correlation(6), 0, 0.06);
}

TEST_F(DepthCameraTest, StructuredLightReadsWholeStepsOfDisparity) {
  const cv::Mat truth = See([](double x, double) { return (1 + 0.2 * x) / 3; });
  const cv::Mat measured = Measure(DepthModel::kStructuredLight, truth);
  for (const float z : cv::Mat_<float>(measured)) {
    if (z == 0) continue;
    const double steps = 8 * 580 * 0.075 / double(z);
    EXPECT_NEAR(steps, std::round(steps), 0.03);  // half a millimetre of 1/z, at 3 m 0.02 steps
    EXPECT_EQ(z, float(std::round(1000 * double(z)) / 1000.0)) << "whole millimetres";
  }
}

TEST_F(DepthCameraTest, StructuredLightHasAShadowOnTheLeftOfWhatStandsBeforeAWall) {
  // A board from x = -0.2 to 0.1 at 1 m before a wall at 2 m.
  const cv::Mat truth = See([](double x, double) { return x > -0.2 && x < 0.1 ? 1.0 : 0.5; });
  const cv::Mat measured = Measure(DepthModel::kStructuredLight, truth);
  const float* row = measured.ptr<float>(120);
  int left = 0, right = 0;
  const double board_left = 159.5 - 0.2 * camera_.fx, board_right = 159.5 + 0.1 * camera_.fx;
  for (int u = 1; u < 319; ++u) {
    if (row[u] > 0) continue;
    (u < 159 ? left : right) += 1;
    EXPECT_LT(std::min(std::abs(u - board_left), std::abs(u - board_right)), 14) << u;
  }
  // f b (1/z1 - 1/z2) = 277 * 0.075 * 0.5 = 10.4 px, and a pixel on either side of an edge.
  EXPECT_NEAR(left, 12, 1.5);
  EXPECT_NEAR(right, 2, 0.5);
}

TEST_F(DepthCameraTest, APoleThinnerThanItsShadowLeavesTheWallBesideItLit) {
  // 4 px wide, of a shadow that lies 10.4 px to the left of it.
  const cv::Mat truth = See([&](double x, double) { return std::abs(x * camera_.fx) < 2 ? 1.0 : 0.5; });
  const cv::Mat measured = Measure(DepthModel::kStructuredLight, truth);
  const float* row = measured.ptr<float>(120);
  int holes = 0;
  for (int u = 1; u < 319; ++u) holes += row[u] == 0;
  EXPECT_NEAR(holes, 4 + 2 * 2, 1.5) << "the shadow and the pole's edges";
  EXPECT_GT(row[153], 0) << "between the pole and its shadow";
}

TEST_F(DepthCameraTest, StructuredLightReadsNothingNearFarOrAtAGrazingAngle) {
  const auto holes = [&](double nearness) {
    const cv::Mat truth = See([&](double, double) { return nearness; });
    return Compare(Measure(DepthModel::kStructuredLight, truth), truth).holes;
  };
  EXPECT_EQ(holes(1 / 0.45), 1);
  EXPECT_EQ(holes(1 / 0.55), 0);
  EXPECT_EQ(holes(1 / 4.7), 0);
  EXPECT_EQ(holes(1 / 5.4), 1);  // ten sigma beyond
  // A floor 0.3 m below: its ray leaves the normal by 80 degrees where y = 1 / tan(80 deg) on the middle column.
  const cv::Mat floor = See([](double, double y) { return y / 0.3; });
  const cv::Mat measured = Measure(DepthModel::kStructuredLight, floor);
  const double last_row = 119.5 + camera_.fx / std::tan(80 * M_PI / 180);
  for (int v = 1; v < 239; ++v) {
    if (std::abs(v - last_row) < 1) continue;
    const float z = floor.at<float>(v, 160);
    EXPECT_EQ(measured.at<float>(v, 160) > 0, v > last_row && z > 0.5f) << v;
  }
}

TEST_F(DepthCameraTest, TimeOfFlightSpreadsByDistanceAndReflectance) {
  const auto spread = [&](double z, int grey) {
    const cv::Mat truth = See([&](double, double) { return 1 / z; });
    return Compare(Measure(DepthModel::kTimeOfFlight, truth, grey), truth);
  };
  // Fankhauser et al. found 1 mm at 1 m and some 6 mm at 4 m on a bright wall; 230 reflects 0.79 of the light. Rays at
  // the image's corners meet it at 36 degrees, which costs up to a quarter.
  EXPECT_NEAR(spread(1, 230).rms_m, 1.1e-3, 0.2e-3);
  EXPECT_NEAR(spread(4, 230).rms_m, 6.8e-3, 0.8e-3);
  // 188 reflects half: as the data sheet has it.
  EXPECT_NEAR(spread(4, 188).rms_m / DepthDataSheet(DepthModel::kTimeOfFlight).Sigma(4), 1, 0.15);
  EXPECT_GT(spread(2, 60).rms_m, 5 * spread(2, 230).rms_m);
  EXPECT_EQ(spread(4, 40).holes, 1) << "too dark";
  EXPECT_EQ(spread(7.5, 230).holes, 0);
  EXPECT_EQ(spread(9, 255).holes, 1) << "too far";
  EXPECT_EQ(spread(0.25, 230).holes, 1) << "too near";
}

TEST_F(DepthCameraTest, TimeOfFlightHasPixelsThatFlyBetweenTwoSurfaces) {
  const cv::Mat truth = See([](double x, double) { return x < 0 ? 1.0 : 0.5; });
  const cv::Mat measured = Measure(DepthModel::kTimeOfFlight, truth);
  int flying = 0;
  for (int v = 10; v < 230; ++v) {
    for (int u = 1; u < 319; ++u) {
      const float z = measured.at<float>(v, u);
      if (z < 1.05f || z > 1.9f) continue;
      ++flying;
      EXPECT_NEAR(u, 159.5, 1);
    }
  }
  EXPECT_GT(flying, 100) << "of 220 rows";
}

TEST_F(DepthCameraTest, TheSameSeedGivesTheSameBitsAndTheIdealCameraTheTruth) {
  const cv::Mat truth = See([](double x, double y) { return 0.5 + 0.1 * x + 0.2 * y; });
  for (const DepthModel model : {DepthModel::kStructuredLight, DepthModel::kTimeOfFlight}) {
    const cv::Mat a = Measure(model, truth), b = Measure(model, truth), c = Measure(model, truth, 188, 2);
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
    EXPECT_GT(cv::norm(a, c, cv::NORM_INF), 0);
  }
  EXPECT_EQ(cv::norm(Measure(DepthModel::kIdeal, truth), truth, cv::NORM_INF), 0);
  EXPECT_EQ(DepthDataSheet(DepthModel::kIdeal).Sigma(3), 0);
}

TEST_F(DepthCameraTest, RegisteredDepthIsThatOfTheCameraItIsRegisteredTo) {
  // A wall that leans, given in the left camera's frame: n p = d.
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.1, 1).normalized();
  const double d = 2;
  const Pose X_LD(ExpSo3(Eigen::Vector3d(0.01, -0.02, 0.015)), {0.05, -0.01, 0.02});
  const Eigen::Vector3d n_D = X_LD.R().transpose() * n;
  const double d_D = d - n.dot(X_LD.translation);
  const cv::Mat seen = See([&](double x, double y) { return n_D.dot(Eigen::Vector3d(x, y, 1)) / d_D; });
  const cv::Mat registered = RegisterDepth(seen, rays(), camera_, X_LD);
  int read = 0;
  for (int v = 20; v < registered.rows - 20; ++v) {
    for (int u = 20; u < registered.cols - 20; ++u) {
      const double z = double(registered.at<float>(v, u));
      if (z == 0) continue;
      const cv::Vec2f& ray = rays().at<cv::Vec2f>(v, u);
      // A reading lies half a pixel off at most, and the wall's depth changes by 0.3 z / f and 0.1 z / f from one to
      // the next.
      EXPECT_NEAR(z, d / n.dot(Eigen::Vector3d(double(ray[0]), double(ray[1]), 1)), 0.5 * 0.5 * z / camera_.fx);
      ++read;
    }
  }
  EXPECT_GT(read, 0.95 * (registered.rows - 40) * (registered.cols - 40)) << "turned pixels leave few holes";
}

TEST_F(DepthCameraTest, WhatStandsInFrontHidesWhatIsRegisteredToTheSamePixel) {
  const cv::Mat seen = See([](double x, double) { return std::abs(x) < 0.1 ? 1.0 : 0.25; });
  const cv::Mat registered = RegisterDepth(seen, rays(), camera_, Pose(Eigen::Quaterniond::Identity(), {0.1, 0, 0}));
  // Parallax is f b / z: the post moves by 28 px to the right, the wall behind it by 7 px, and to the post's left no
  // reading is left of what only the left camera sees.
  const int row = camera_.height_px / 2, post = int(camera_.cx + camera_.fx * 0.1);
  for (int u = post - 24; u < post + 24; ++u) EXPECT_NEAR(registered.at<float>(row, u), 1, 1e-6) << u;
  EXPECT_NEAR(registered.at<float>(row, post + 36), 4, 1e-6);
  EXPECT_EQ(registered.at<float>(row, post - 36), 0);
}

TEST_F(DepthCameraTest, ARegistrationErrsBySeedAndAsFarAsItSays) {
  DepthMountOptions options;
  double moved2 = 0, turned2 = 0;
  constexpr int kSeeds = 200;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const DepthMount mount = DepthMount::Of(options, RandomStream(seed, "mount"));
    EXPECT_EQ(mount.X_LD.translation, Eigen::Vector3d(options.right_m, 0, 0));
    const Pose error = mount.X_LD.Inverse() * mount.X_LD_believed;
    moved2 += error.translation.squaredNorm() / 3;
    turned2 += LogSo3(error.rotation).squaredNorm() / 3;
  }
  // Of 600 normal numbers the root mean square is known to 3 %; four times that.
  EXPECT_NEAR(std::sqrt(moved2 / kSeeds), options.error_m, 0.12 * options.error_m);
  EXPECT_NEAR(kDegPerRad * std::sqrt(turned2 / kSeeds), options.error_deg, 0.12 * options.error_deg);
  options.error_m = options.error_deg = 0;
  const DepthMount exact = DepthMount::Of(options, RandomStream(1, "mount"));
  EXPECT_EQ(exact.X_LD.translation, exact.X_LD_believed.translation);
}

}  // namespace
}  // namespace gaitcam
