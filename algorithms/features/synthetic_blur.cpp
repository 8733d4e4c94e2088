#include "algorithms/features/synthetic_blur.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/core/random.h"

namespace gaitcam {

cv::Mat LineBlurKernel(const LineBlur& blur) {
  const int radius = int(std::ceil(blur.extent_px / 2)) + 1, points = std::max(50, int(blur.extent_px * 20));
  cv::Mat kernel(2 * radius + 1, 2 * radius + 1, CV_32FC1, cv::Scalar(0));
  for (int i = 0; i < points; ++i) {
    const double t = ((i + 0.5) / points - 0.5) * blur.extent_px;
    const double x = radius + t * std::cos(blur.direction_rad), y = radius + t * std::sin(blur.direction_rad);
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    for (int v = 0; v < 2; ++v) {
      for (int u = 0; u < 2; ++u) {
        const double share = (u ? x - x0 : 1 - x + x0) * (v ? y - y0 : 1 - y + y0);
        kernel.at<float>(y0 + v, x0 + u) += float(share / points);
      }
    }
  }
  return kernel;
}

cv::Mat BlurPhotograph(const cv::Mat& grey, const LineBlur& blur, double noise, uint64_t seed, bool linear_light,
                       cv::Size size) {
  const int margin = int(std::ceil(blur.extent_px / 2)) + 1;
  const cv::Size outer(std::min(grey.cols, size.width + 2 * margin), std::min(grey.rows, size.height + 2 * margin));
  const cv::Rect middle({(grey.cols - outer.width) / 2, (grey.rows - outer.height) / 2}, outer);
  cv::Mat values;
  grey(middle).convertTo(values, CV_32F, 1 / 255.0);
  if (linear_light) cv::pow(values, 2.2, values);
  if (blur.extent_px > 0) {
    cv::filter2D(values.clone(), values, CV_32F, LineBlurKernel(blur), {-1, -1}, 0, cv::BORDER_REFLECT_101);
  }
  if (linear_light) {
    values = cv::max(values, 0);
    cv::pow(values, 1 / 2.2, values);
  }
  values = values(cv::Rect(margin, margin, outer.width - 2 * margin, outer.height - 2 * margin)) * 255;
  RandomStream random(seed, "noise");
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) values.at<float>(y, x) += float(random.Normal(0, noise));
  }
  cv::Mat rounded;
  values.convertTo(rounded, CV_8U);
  return rounded;
}

BlurPath ImageMotion::PathAt(const Eigen::Vector2d& pixel) const {
  BlurPath path;
  for (size_t i = 0; i < shifts.size(); ++i) {
    const Eigen::Vector2d arm = pixel - centre;
    path.points.push_back(Eigen::Rotation2Dd(turns_rad[i]) * arm - arm + shifts[i]);
  }
  return path;
}

ImageMotion ImageMotion::Cropped(const Eigen::Vector2d& corner) const {
  ImageMotion motion = *this;
  motion.centre -= corner;
  return motion;
}

namespace {

/// Median over a rectangle's pixels of the distance to its middle.
double MedianArm(const cv::Size& image) {
  std::vector<double> arms;
  for (int y = 0; y < image.height; y += 4)
    for (int x = 0; x < image.width; x += 4)
      arms.push_back(std::hypot(x - 0.5 * (image.width - 1), y - 0.5 * (image.height - 1)));
  return UpperMedian(arms);
}

/// Two sines per axis, scaled to `most_px` where they are largest.
std::vector<Eigen::Vector2d> DrawJitter(const std::vector<double>& times, double most_px, RandomStream& random) {
  std::vector<Eigen::Vector2d> jitter(times.size(), Eigen::Vector2d::Zero());
  for (int axis = 0; axis < 2; ++axis)
    for (int wave = 0; wave < 2; ++wave) {
      const double cycles = random.Uniform(1, 4), phase = random.Uniform(0, 2 * M_PI);
      for (size_t i = 0; i < times.size(); ++i) jitter[i][axis] += std::sin(2 * M_PI * cycles * times[i] + phase);
    }
  double largest = 0;
  for (const Eigen::Vector2d& j : jitter) largest = std::max(largest, j.lpNorm<Eigen::Infinity>());
  for (Eigen::Vector2d& j : jitter) j *= most_px / largest;
  return jitter;
}

/// Shifts along x at these times, 0 being shutter open and 1 close, for a path of length 1.
std::vector<Eigen::Vector2d> UnitShifts(BlurKind kind, const std::vector<double>& times, RandomStream& random) {
  constexpr double kSteepness = 2.0 / 3, kBend_rad = M_PI / 2;
  const double sign = random.Uniform() < 0.5 ? -1 : 1;
  std::vector<Eigen::Vector2d> shifts;
  for (const double t : times) {
    Eigen::Vector2d shift(t, 0);
    if (kind == BlurKind::kRamp) shift.x() = t + sign * kSteepness * (t * t - t);
    if (kind == BlurKind::kArc)
      shift = Eigen::Vector2d(std::sin(kBend_rad * t), sign * (1 - std::cos(kBend_rad * t))) / kBend_rad;
    shifts.push_back(shift);
  }
  return shifts;
}

}  // namespace

ImageMotion DrawMotion(BlurKind kind, double extent_px, const cv::Size& image, uint64_t seed) {
  RandomStream random(seed, "motion");
  ImageMotion motion;
  motion.centre = 0.5 * Eigen::Vector2d(image.width - 1, image.height - 1);
  const int steps = 8 + int(4 * extent_px);
  std::vector<double> times;
  for (int i = 0; i <= steps; ++i) times.push_back(double(i) / steps);
  motion.turns_rad.assign(times.size(), 0.0);
  motion.shifts.assign(times.size(), Eigen::Vector2d::Zero());
  const double direction = random.Uniform(0, 2 * M_PI);
  if (kind == BlurKind::kRotation) {
    const double turn = (random.Uniform() < 0.5 ? -1 : 1) * extent_px / MedianArm(image);
    for (size_t i = 0; i < times.size(); ++i) motion.turns_rad[i] = (times[i] - 0.5) * turn;
    return motion;
  }
  const std::vector<Eigen::Vector2d> unit = UnitShifts(kind, times, random);
  for (size_t i = 0; i < times.size(); ++i) motion.shifts[i] = Eigen::Rotation2Dd(direction) * (extent_px * unit[i]);
  if (kind == BlurKind::kJitter && extent_px > 0) {
    const std::vector<Eigen::Vector2d> jitter = DrawJitter(times, 1.5, random);
    for (size_t i = 0; i < times.size(); ++i) motion.shifts[i] += jitter[i];
  }
  // The mean over time, so that no detector gains by where it thinks that a point of a bent path lies.
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i + 1 < times.size(); ++i) mean += 0.5 * (motion.shifts[i] + motion.shifts[i + 1]) / steps;
  for (Eigen::Vector2d& shift : motion.shifts) shift -= mean;
  return motion;
}

cv::Mat BlurAlong(const cv::Mat& image, const ImageMotion& motion) {
  GAITCAM_ASSERT(image.type() == CV_32FC1 && motion.shifts.size() == motion.turns_rad.size());
  if (motion.shifts.size() < 2) return image.clone();
  cv::Mat sum = cv::Mat::zeros(image.size(), CV_32FC1), moved;
  for (size_t i = 0; i + 1 < motion.shifts.size(); ++i) {
    const Eigen::Matrix2d R =
        Eigen::Rotation2Dd(0.5 * (motion.turns_rad[i] + motion.turns_rad[i + 1])).toRotationMatrix();
    const Eigen::Vector2d t = motion.centre - R * motion.centre + 0.5 * (motion.shifts[i] + motion.shifts[i + 1]);
    const cv::Matx23d M(R(0, 0), R(0, 1), t.x(), R(1, 0), R(1, 1), t.y());
    cv::warpAffine(image, moved, M, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    sum += moved;
  }
  return sum / double(motion.shifts.size() - 1);
}

double BlurVectorError(const Eigen::Vector2d& a, const cv::Vec2f& b) {
  const Eigen::Vector2d other{double(b[0]), double(b[1])};
  return std::min((a - other).norm(), (a + other).norm());
}

}  // namespace gaitcam
