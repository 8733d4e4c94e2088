// Direct alignment of a plane on images with known motion: a smooth random texture by an ideal camera.

#include "algorithms/planes/plane_alignment.h"

#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "algorithms/core/random.h"
#include "algorithms/planes/floor_keyframe.h"
#include "tests/algorithms/planes/drawn_floor.h"

namespace gaitcam {
namespace {

const CameraModel kCamera = CameraModel::FromHorizontalFov(320, 240, 60);

constexpr double kHeight_m = 0.4, kPitch_rad = 35 * M_PI / 180;

/// Waves of 10 to 50 cm: 8 px and more in the images below, so that bilinear interpolation hardly dims them.
DrawnFloor Texture(uint64_t seed) { return DrawnFloor(seed, 0.1); }

/// The floor as a camera of a small humanoid sees it, which has not moved.
PlaneState TrueState() { return FloorPlaneState(CameraOver({}, kHeight_m, kPitch_rad)); }

/// The image of a camera that has moved by X_CR from there.
cv::Mat Render(const DrawnFloor& floor, const std::vector<Pose>& X_CR, double noise_grey = 0, uint64_t seed = 1) {
  std::vector<Pose> exposure;
  for (const Pose& X : X_CR) exposure.push_back(CameraOver({}, kHeight_m, kPitch_rad) * X.Inverse());
  return Draw(floor, exposure, DrawOptions{kCamera, noise_grey, seed, 2, {}});
}

cv::Mat Render(const DrawnFloor& floor, const PlaneState& state, double noise_grey = 0, uint64_t seed = 1) {
  return Render(floor, std::vector<Pose>{state.X_CR}, noise_grey, seed);
}

/// The part of the image that shows floor within some 1.2 m.
cv::Mat FloorMask(const PlaneState& state) {
  cv::Mat mask(kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < mask.rows; ++v) {
    for (int u = 0; u < mask.cols; ++u) {
      mask.at<uchar>(v, u) = state.normal_d.dot(kCamera.Unproject({double(u), double(v)})) > 0.8 ? 255 : 0;
    }
  }
  return mask;
}

Pose Motion(double tx, double ty, double tz, double rx_deg, double ry_deg, double rz_deg) {
  Vector6d x;
  x << tx, ty, tz, Eigen::Vector3d(rx_deg, ry_deg, rz_deg) * M_PI / 180;
  return ExpSe3(x);
}

/// Mean distance between the floor's pixels as warped by two states.
double MeanWarpError(const PlaneState& a, const PlaneState& b, const cv::Mat& mask) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v < mask.rows; v += 8) {
    for (int u = 0; u < mask.cols; u += 8) {
      const auto pa = WarpPixel(kCamera, a, {double(u), double(v)}), pb = WarpPixel(kCamera, b, {double(u), double(v)});
      if (mask.at<uchar>(v, u) == 0 || !pa || !pb) continue;
      sum += (*pa - *pb).norm();
      ++count;
    }
  }
  return sum / count;
}

TEST(WarpJacobian, AgreesWithFiniteDifferences) {
  PlaneState state = TrueState();
  state.X_CR = Motion(0.03, -0.02, 0.05, 3, -2, 4);
  const std::vector<Eigen::Vector3d> rays{kCamera.Unproject({0, 239}), kCamera.Unproject({319, 239}),
                                          kCamera.Unproject({160, 120})};
  const Eigen::Matrix3d M = internal::NormalFromInverseDepths(rays);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(50, 200), Eigen::Vector2d(250, 150), Eigen::Vector2d(160, 220)}) {
    const auto J = internal::WarpJacobian(kCamera, 1, state, M, p);
    for (int k = 0; k < 9; ++k) {
      Eigen::Vector2d ends[2];
      constexpr double kStep = 1e-5;
      for (const int side : {0, 1}) {
        const double h = side == 0 ? -kStep : kStep;
        PlaneState moved = state;
        if (k < 6) {
          moved.X_CR = state.X_CR * ExpSe3(h * Vector6d::Unit(k));
        } else {
          Eigen::Vector3d z = M.inverse() * state.normal_d;
          z[k - 6] *= std::exp(h);
          moved.normal_d = M * z;
        }
        ends[side] = *WarpPixel(kCamera, moved, p);
      }
      // Central differences at 1e-5 err by the third derivative times 1e-10: some 1e-6 px here.
      EXPECT_LT((J.col(k) - (ends[1] - ends[0]) / (2 * kStep)).norm(), 1e-4) << k;
    }
  }
}

/// Eqs. 6.5 to 6.16 for automatic differentiation.
using Jet = ceres::Jet<double, 9>;
std::array<Jet, 2> WarpByEquations(const PlaneState& state, const Eigen::Matrix3d& M, const Eigen::Vector2d& p_R) {
  Jet theta[9];
  for (int k = 0; k < 9; ++k) theta[k] = Jet(0, k);
  const Eigen::Vector3d z = M.inverse() * state.normal_d, ray = kCamera.Unproject(p_R);
  Jet depth_inverse(0);  // n_d(z exp(y)) . ray
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) depth_inverse += ray[i] * M(i, j) * z[j] * exp(theta[6 + j]);
  }
  const Jet point[3] = {Jet(ray[0]) / depth_inverse, Jet(ray[1]) / depth_inverse, Jet(ray[2]) / depth_inverse};
  Jet turned[3];
  ceres::AngleAxisRotatePoint(theta + 3, point, turned);  // beside it, exp moves by theta: to first order, at zero
  const Eigen::Matrix3d R = state.X_CR.R();
  Jet seen[3];
  for (int i = 0; i < 3; ++i) {
    seen[i] = Jet(state.X_CR.translation[i]);
    for (int j = 0; j < 3; ++j) seen[i] += R(i, j) * (turned[j] + theta[j]);
  }
  return {kCamera.fx * seen[0] / seen[2] + kCamera.cx, kCamera.fy * seen[1] / seen[2] + kCamera.cy};
}

TEST(WarpJacobian, AgreesWithAutomaticDifferentiation) {
  RandomStream random(3, "states");
  const std::vector<Eigen::Vector3d> rays{kCamera.Unproject({0, 239}), kCamera.Unproject({319, 239}),
                                          kCamera.Unproject({160, 120})};
  const Eigen::Matrix3d M = internal::NormalFromInverseDepths(rays);
  for (int trial = 0; trial < 50; ++trial) {
    PlaneState state = TrueState();
    state.X_CR = Motion(random.Normal() * 0.05, random.Normal() * 0.05, random.Normal() * 0.05, random.Normal() * 5,
                        random.Normal() * 5, random.Normal() * 5);
    state.normal_d += 0.1 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector2d p(random.Uniform(0, 319), random.Uniform(120, 239));
    const std::array<Jet, 2> warped = WarpByEquations(state, M, p);
    const auto J = internal::WarpJacobian(kCamera, 1, state, M, p);
    const std::optional<Eigen::Vector2d> pixel = WarpPixel(kCamera, state, p);
    ASSERT_TRUE(pixel);
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(warped[size_t(i)].a, (*pixel)[i], 1e-9);
      // Both are exact but for rounding.
      EXPECT_LT((warped[size_t(i)].v.transpose() - J.row(i)).norm(), 1e-9 * J.norm());
    }
  }
}

struct Trial {
  PlaneState truth;
  PlaneAlignment found;
  double error_px = 0, initial_px = 0;
};

/// Two images a known motion apart, aligned from the identity; the plane is known to 1 % and 1 degree.
Trial Align(const Pose& motion, uint64_t seed, double noise_grey = 0, const PlaneAlignmentOptions& options = {}) {
  const DrawnFloor texture = Texture(seed);
  Trial trial;
  trial.truth = TrueState();
  const cv::Mat mask = FloorMask(trial.truth), first = Render(texture, trial.truth, noise_grey, 2 * seed);
  trial.truth.X_CR = motion;
  const cv::Mat second = Render(texture, trial.truth, noise_grey, 2 * seed + 1);
  const PlaneAligner aligner(kCamera, options);
  const PlaneReference reference = aligner.MakeReference(first, mask);
  PlanePrior prior;
  prior.tilt_sigma_rad = 0.02;
  trial.found = aligner.Align(reference, aligner.MakePyramid(second), TrueState(), prior);
  trial.error_px = MeanWarpError(trial.found.state, trial.truth, mask);
  trial.initial_px = MeanWarpError(TrueState(), trial.truth, mask);
  return trial;
}

TEST(PlaneAlignment, FindsSmallMotionsToAFewHundredthsOfAPixel) {
  const Trial trial = Align(Motion(0.004, 0.002, -0.006, 0.3, 0.4, -0.5), 3);
  EXPECT_TRUE(trial.found.converged);
  EXPECT_GT(trial.initial_px, 1.5);
  EXPECT_LT(trial.error_px, 0.05);
  EXPECT_LT((trial.found.state.X_CR.translation - trial.truth.X_CR.translation).norm(), 0.0005);
}

TEST(PlaneAlignment, ConvergesFromTwentyPixelsAway) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    RandomStream random(seed, "direction");
    const double angle = random.Uniform(0, 2 * M_PI);
    const Trial trial = Align(Motion(0.02 * std::cos(angle), 0, 0.02 * std::sin(angle), 3 * std::sin(angle),
                                     3 * std::cos(angle), random.Uniform(-2, 2)),
                              seed);
    EXPECT_TRUE(trial.found.converged);
    EXPECT_GT(trial.initial_px, 10);
    EXPECT_LT(trial.error_px, 0.1) << "seed " << seed << " from " << trial.initial_px << " px";
  }
}

TEST(PlaneAlignment, EveryMotionWithinEightPixelsIsFound) {
  const cv::Mat mask = FloorMask(TrueState());
  for (uint64_t seed = 1; seed <= 16; ++seed) {
    RandomStream random(seed, "motion");
    Vector6d motion;
    for (int k = 0; k < 6; ++k) motion[k] = random.Normal() * (k < 3 ? 0.004 : 0.01);
    const double wanted_px = random.Uniform(1, 8);
    for (int i = 0; i < 4; ++i) {  // displacement is nearly linear in the motion
      PlaneState moved = TrueState();
      moved.X_CR = ExpSe3(motion);
      motion *= wanted_px / MeanWarpError(moved, TrueState(), mask);
    }
    const Trial trial = Align(ExpSe3(motion), seed);
    EXPECT_TRUE(trial.found.converged);
    EXPECT_NEAR(trial.initial_px, wanted_px, 0.1);
    // The finest waves are 8 px long where the picture's pixels are compared, far away less: interpolation errs there.
    EXPECT_LT(trial.error_px, 0.1) << "seed " << seed << " from " << trial.initial_px << " px";
  }
}

TEST(PlaneAlignment, ErrorsAreWhatTheCovarianceSays) {
  double sum2 = 0;
  constexpr int kTrials = 16;
  for (uint64_t seed = 1; seed <= kTrials; ++seed) {
    const Trial trial = Align(Motion(0.004, 0.002, -0.006, 0.3, 0.4, -0.5), seed, 3);
    const Vector6d error = LogSe3(trial.found.state.X_CR.Inverse() * trial.truth.X_CR);
    sum2 += error.dot(trial.found.motion_covariance.inverse() * error) / 6;
  }
  // Chi-square over its degrees of freedom, known to 14 % from 96 of them. Gradients are taken for exact, which noise
  // of 3 grey levels makes wrong by a third (1.41 over 40 seeds). A covariance twice as large or half as large fails.
  EXPECT_LT(sum2 / kTrials, 2);
  EXPECT_GT(sum2 / kTrials, 0.8);
}

TEST(PlaneAlignment, BrightnessMayChange) {
  const DrawnFloor texture = Texture(4);
  PlaneState truth = TrueState();
  const cv::Mat mask = FloorMask(truth), first = Render(texture, truth);
  truth.X_CR = Motion(0.004, 0, -0.004, 0.2, 0.3, 0);
  cv::Mat second;
  Render(texture, truth).convertTo(second, CV_8U, 0.8, 12);
  const PlaneAligner aligner(kCamera, {});
  const PlaneAlignment found =
      aligner.Align(aligner.MakeReference(first, mask), aligner.MakePyramid(second), TrueState(), {});
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.state.gain, 0.8, 0.02);
  EXPECT_NEAR(found.state.offset, 12, 3);
  EXPECT_LT(MeanWarpError(found.state, truth, mask), 0.2);  // rounding to fewer grey levels
}

TEST(PlaneAlignment, AQuarterOfTheFloorHiddenDoesNotMatter) {
  const DrawnFloor texture = Texture(5), other = Texture(99);
  PlaneState truth = TrueState();
  const cv::Mat mask = FloorMask(truth), first = Render(texture, truth);
  truth.X_CR = Motion(0.004, 0, -0.004, 0.2, 0.3, 0);
  cv::Mat second = Render(texture, truth);
  const cv::Rect hidden(100, 120, 120, 90);
  Render(other, TrueState())(hidden).copyTo(second(hidden));
  const PlaneAligner aligner(kCamera, {});
  const PlaneAlignment found =
      aligner.Align(aligner.MakeReference(first, mask), aligner.MakePyramid(second), TrueState(), {});
  EXPECT_TRUE(found.converged);
  EXPECT_LT(MeanWarpError(found.state, truth, mask), 0.3);
  EXPECT_GT(found.inliers, aligner.options().max_points / 2);
}

TEST(PlaneAlignment, AnotherFloorIsNotTakenForThisOne) {
  const PlaneState state = TrueState();
  PlaneAlignmentOptions options;
  options.max_residual_grey = 20;
  const PlaneAligner aligner(kCamera, options);
  const PlaneReference reference = aligner.MakeReference(Render(Texture(6), state), FloorMask(state));
  EXPECT_FALSE(aligner.Align(reference, aligner.MakePyramid(Render(Texture(7), state)), state, {}).converged);
  const cv::Mat black(kCamera.height_px, kCamera.width_px, CV_8UC1, cv::Scalar(0));
  const PlaneAlignment dark = aligner.Align(reference, aligner.MakePyramid(black), state, {});
  EXPECT_TRUE(dark.state.X_CR.translation.allFinite());
}

/// The image of an exposure about the state's pose.
cv::Mat RenderBlurred(const DrawnFloor& floor, const PlaneState& middle, const BlurMotion& motion) {
  constexpr int kInstants = 15;
  std::vector<Pose> exposure;
  for (int i = 0; i < kInstants; ++i) {
    exposure.push_back(ExpSe3(((i + 0.5) / kInstants - 0.5) * motion) * middle.X_CR);
  }
  return Render(floor, exposure);
}

TEST(PlaneAlignment, BlurOfTheCurrentImageIsPartOfTheModel) {
  const DrawnFloor texture = Texture(8);
  PlaneState truth = TrueState();
  const cv::Mat mask = FloorMask(truth), first = Render(texture, truth);
  truth.X_CR = Motion(0.006, 0, -0.01, 1.0, 1.5, 1.0);
  constexpr double kBlurRatio = 0.9;
  const cv::Mat second = RenderBlurred(texture, truth, kBlurRatio * LogSe3(truth.X_CR));
  const auto error_px = [&](double ratio, int samples) {
    PlaneAlignmentOptions options;
    options.max_blur_samples = samples;
    const PlaneAligner aligner(kCamera, options);
    const PlaneAlignment found =
        aligner.Align(aligner.MakeReference(first, mask), aligner.MakePyramid(second), TrueState(), {}, ratio);
    return MeanWarpError(found.state, truth, mask);
  };
  const double modelled = error_px(kBlurRatio, 9), ignored = error_px(0, 1);
  EXPECT_LT(modelled, 0.15);
  EXPECT_LT(modelled, 0.7 * ignored);
}

}  // namespace
}  // namespace gaitcam
