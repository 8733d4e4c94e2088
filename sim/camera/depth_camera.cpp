#include "sim/camera/depth_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

constexpr double kMillimetre = 1e-3;

// Structured light.
constexpr double kBaseline_m = 0.075, kFocal_px = 580, kFocalBaseline_px_m = kFocal_px * kBaseline_m;
constexpr double kWindow_px = 9;
constexpr double kDisparityStep_px = 1.0 / 8;
constexpr double kDisparitySigma_steps = 0.5;  // quantisation included
constexpr float kPatternNear_m = 0.5f, kPatternFar_m = 5.f;
const float kGrazingCosine = float(std::cos(80 * kRadPerDeg));
constexpr float kSameSurface = 0.05f;  // neighbours whose depths differ by a smaller part belong together
constexpr float kShadowMargin = 0.02f;

// Time of flight.
constexpr double kRangeSigma_m = 0.84e-3, kAmbient = 0.1, kWorstSigma_m = 0.05;
constexpr float kPulseNear_m = 0.3f, kPulseFar_m = 8.f;
constexpr float kFootprint[] = {0.107f, 0.786f, 0.107f};  // a Gaussian of 0.5 px, integrated over pixels

float WholeMillimetres(double z) { return float(std::round(z / kMillimetre) / 1000.0); }

/// The cosine of the angle between a pixel's ray and the normal of what it sees; 0 where that is not known.
///
/// On a plane 1/z = a x + b y + c in ray coordinates (x, y), of normal (a, b, c): its product with the ray (x, y, 1) is
/// 1/z itself.
cv::Mat IncidenceCosine(const cv::Mat& depth, const cv::Mat& rays) {
  cv::Mat cosine(depth.size(), CV_32FC1, cv::Scalar(0));
  for (int v = 1; v + 1 < depth.rows; ++v) {
    for (int u = 1; u + 1 < depth.cols; ++u) {
      const float z = depth.at<float>(v, u), left = depth.at<float>(v, u - 1), right = depth.at<float>(v, u + 1),
                  up = depth.at<float>(v - 1, u), down = depth.at<float>(v + 1, u);
      if (!(z > 0 && left > 0 && right > 0 && up > 0 && down > 0)) continue;
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(v, u);
      const cv::Vec2f across = rays.at<cv::Vec2f>(v, u + 1) - rays.at<cv::Vec2f>(v, u - 1);
      const cv::Vec2f along = rays.at<cv::Vec2f>(v + 1, u) - rays.at<cv::Vec2f>(v - 1, u);
      const float du = 1 / right - 1 / left, dv = 1 / down - 1 / up;
      const float area = across[0] * along[1] - across[1] * along[0];
      const float a = (du * along[1] - dv * across[1]) / area, b = (dv * across[0] - du * along[0]) / area;
      const float c = 1 / z - a * ray[0] - b * ray[1];
      const float length = std::sqrt((a * a + b * b + c * c) * (ray[0] * ray[0] + ray[1] * ray[1] + 1));
      cosine.at<float>(v, u) = 1 / (z * length);
    }
  }
  return cosine;
}

/// Pixels per unit of X/Z.
double FocalLength(const cv::Mat& rays) {
  const int last = rays.cols - 1, middle = rays.rows / 2;
  return last / double(rays.at<cv::Vec2f>(middle, last)[0] - rays.at<cv::Vec2f>(middle, 0)[0]);
}

/// What a projector beside the camera lights, row by row: a depth buffer of its own picture.
class ProjectorShadow {
 public:
  /// @param rays of the whole image: their spacing is the buffer's.
  explicit ProjectorShadow(const cv::Mat& rays)
      : left_(rays.at<cv::Vec2f>(rays.rows / 2, 0)[0]), cells_per_unit_(float(FocalLength(rays))) {
    farthest_shift_ = int(std::ceil(kBaseline_m / kNearest_m * cells_per_unit_)) + 2;
    cells_.resize(size_t(rays.cols + 2 * farthest_shift_));
  }

  /// @param depth, rays of one row. @param lit 1 for each pixel that the projector sees.
  void Row(const float* depth, const cv::Vec2f* rays, int width, std::vector<uint8_t>& lit) {
    std::fill(cells_.begin(), cells_.end(), std::numeric_limits<float>::infinity());
    for (int u = 0; u < width; ++u) {
      if (depth[u] <= 0) continue;
      const float at = Cell(rays[u][0], depth[u]);
      // As far as its neighbour's, if both are of one surface, so that what is seen at a slant leaves no gaps.
      const bool joined =
          u + 1 < width && depth[u + 1] > 0 && std::abs(depth[u + 1] - depth[u]) < kSameSurface * depth[u];
      const float to = joined ? Cell(rays[u + 1][0], depth[u + 1]) : at;
      const float far = joined ? std::max(depth[u], depth[u + 1]) : depth[u];
      for (int cell = Index(std::min(at, to)); cell <= Index(std::max(at, to)); ++cell)
        cells_[size_t(cell)] = std::min(cells_[size_t(cell)], far);
    }
    lit.assign(size_t(width), 0);
    for (int u = 0; u < width; ++u) {
      const float nearest = cells_[size_t(Index(Cell(rays[u][0], depth[u])))];
      lit[size_t(u)] = depth[u] > 0 && nearest >= (1 - kShadowMargin - kSameSurface) * depth[u];
    }
  }

 private:
  static constexpr double kNearest_m = 0.1;  ///< What is nearer shifts by no more.

  float Cell(float x, float z) const {
    return (x - float(kBaseline_m) / std::max(z, float(kNearest_m)) - left_) * cells_per_unit_;
  }
  int Index(float cell) const {
    return std::clamp(int(std::lround(cell)) + farthest_shift_, 0, int(cells_.size()) - 1);
  }

  float left_, cells_per_unit_;
  int farthest_shift_ = 0;
  std::vector<float> cells_;
};

/// Normal noise of unit variance that pixels share as far as their square windows overlap. @param window odd, px.
cv::Mat WindowedNoise(cv::Size size, int window, RandomStream noise) {
  cv::Mat white(size.height + window - 1, size.width + window - 1, CV_64FC1), sums;
  for (double& value : cv::Mat_<double>(white)) value = noise.Normal();
  cv::boxFilter(white, sums, CV_64F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sums(cv::Rect({window / 2, window / 2}, size)) / window;
}

cv::Mat StructuredLight(const cv::Mat& depth, const cv::Mat& rays, RandomStream noise) {
  // Rounding to whole steps alone has a variance of 1/12 of a step's square.
  const double sigma = std::sqrt(kDisparitySigma_steps * kDisparitySigma_steps - 1.0 / 12);
  const double steps_m = kFocalBaseline_px_m / kDisparityStep_px;
  const int window = 2 * int(std::lround((kWindow_px * FocalLength(rays) / kFocal_px - 1) / 2)) + 1;
  const cv::Mat errors = WindowedNoise(depth.size(), std::max(1, window), noise);
  const cv::Mat cosine = IncidenceCosine(depth, rays);
  ProjectorShadow shadow(rays);
  std::vector<uint8_t> lit;
  cv::Mat measured(depth.size(), CV_32FC1, cv::Scalar(0));
  for (int v = 0; v < depth.rows; ++v) {
    const float* z = depth.ptr<float>(v);
    shadow.Row(z, rays.ptr<cv::Vec2f>(v), depth.cols, lit);
    for (int u = 0; u < depth.cols; ++u) {
      if (!lit[size_t(u)] || cosine.at<float>(v, u) < kGrazingCosine) continue;
      const double steps = std::round(steps_m / double(z[u]) + sigma * errors.at<double>(v, u));
      const float reading = steps > 0 ? WholeMillimetres(steps_m / steps) : 0.f;
      if (reading >= kPatternNear_m && reading <= kPatternFar_m) measured.at<float>(v, u) = reading;
    }
  }
  return measured;
}

/// Reflectance by the picture: grey, linear.
cv::Mat ReflectanceOf(const cv::Mat& image) {
  cv::Mat grey = image, table(1, 256, CV_32FC1), reflectance;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  for (int code = 0; code < 256; ++code) table.at<float>(code) = float(SrgbToLinear(code / 255.0));
  cv::LUT(grey, table, reflectance);
  return reflectance;
}

cv::Mat TimeOfFlight(const cv::Mat& depth, const cv::Mat& rays, const cv::Mat& image, RandomStream noise) {
  const cv::Mat reflectance = ReflectanceOf(image);
  cv::Mat amplitude = cv::max(IncidenceCosine(depth, rays), 0.05f), squares;
  cv::multiply(depth, depth, squares);
  cv::multiply(amplitude, reflectance, amplitude);
  cv::divide(amplitude, squares, amplitude);
  amplitude.setTo(0, depth <= 0);
  cv::Mat weighted, mean;
  cv::multiply(amplitude, depth, weighted);
  const cv::Mat footprint(1, 3, CV_32FC1, const_cast<float*>(kFootprint));
  cv::sepFilter2D(weighted, weighted, CV_32F, footprint, footprint);
  cv::sepFilter2D(amplitude, mean, CV_32F, footprint, footprint);
  cv::Mat measured(depth.size(), CV_32FC1, cv::Scalar(0));
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double error = noise.Normal(), a = double(mean.at<float>(v, u));
      if (depth.at<float>(v, u) <= 0 || a <= 0) continue;
      const double sigma = kRangeSigma_m * std::sqrt(a + kAmbient) / a;
      if (sigma > kWorstSigma_m) continue;
      const float reading = WholeMillimetres(double(weighted.at<float>(v, u)) / a + sigma * error);
      if (reading >= kPulseNear_m && reading <= kPulseFar_m) measured.at<float>(v, u) = reading;
    }
  }
  return measured;
}

}  // namespace

DepthMount DepthMount::Of(const DepthMountOptions& options, RandomStream errors) {
  const auto three = [&](double sigma) {
    const double x = errors.Normal(), y = errors.Normal();
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, errors.Normal()));
  };
  const Pose X_LD(Eigen::Quaterniond::Identity(), {options.right_m, 0, 0});
  const Eigen::Vector3d moved_m = three(options.error_m), turned_rad = three(kRadPerDeg * options.error_deg);
  return {X_LD, X_LD * Pose(ExpSo3(turned_rad), moved_m)};
}

cv::Mat RegisterDepth(const cv::Mat& depth, const cv::Mat& rays, const CameraModel& camera, const Pose& X_LD) {
  cv::Mat registered(depth.size(), CV_32FC1, cv::Scalar(0));
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = double(depth.at<float>(v, u));
      if (!(z > 0)) continue;
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(v, u);
      const Eigen::Vector3d p_L = X_LD * Eigen::Vector3d(z * double(ray[0]), z * double(ray[1]), z);
      const std::optional<Eigen::Vector2d> at = camera.Project(p_L);
      if (!at) continue;
      const cv::Point pixel(int(std::lround(at->x())), int(std::lround(at->y())));
      if (!cv::Rect({0, 0}, depth.size()).contains(pixel)) continue;
      float& there = registered.at<float>(pixel);
      if (there == 0 || float(p_L.z()) < there) there = float(p_L.z());
    }
  }
  return registered;
}

DepthCalibration DepthDataSheet(DepthModel model) {
  const double rounding_m = kMillimetre / std::sqrt(12.0);
  switch (model) {
    case DepthModel::kIdeal: return {};
    case DepthModel::kStructuredLight:
      return {rounding_m, kDisparitySigma_steps * kDisparityStep_px / kFocalBaseline_px_m};
    case DepthModel::kTimeOfFlight: {
      // K sqrt(A + B) / A with A = 1/2 / z^2 at 4 m, where half of the range is.
      const double amplitude = 0.5 / 16;
      return {kMillimetre, kRangeSigma_m * std::sqrt(amplitude + kAmbient) / amplitude / 16};
    }
  }
  GAITCAM_ASSERT(false);
  return {};
}

cv::Mat MeasureDepth(DepthModel model, const cv::Mat& depth, const cv::Mat& rays, const cv::Mat& image,
                     RandomStream noise) {
  GAITCAM_ASSERT(depth.type() == CV_32FC1 && rays.type() == CV_32FC2 && rays.size() == depth.size());
  switch (model) {
    case DepthModel::kIdeal: return depth;
    case DepthModel::kStructuredLight: return StructuredLight(depth, rays, noise);
    case DepthModel::kTimeOfFlight: return TimeOfFlight(depth, rays, image, noise);
  }
  GAITCAM_ASSERT(false);
  return {};
}

}  // namespace gaitcam
