#include "algorithms/planes/plane_alignment.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

using Matrix11 = Eigen::Matrix<double, 11, 11>;
using Vector11 = Eigen::Matrix<double, 11, 1>;

/// 1.4826 times the median of absolute values: a Gaussian's standard deviation, robust to outliers.
double RobustSigma(const std::vector<PlaneResidual>& residuals) {
  std::vector<double> values;
  values.reserve(residuals.size());
  for (const PlaneResidual& r : residuals) values.push_back(std::abs(r.value));
  return 1.4826 * UpperMedian(std::move(values));
}

/// Normal equations of one step, in (tau, log inverse depths, gain, offset).
struct Equations {
  Matrix11 H = Matrix11::Zero();
  Vector11 g = Vector11::Zero();
};

Equations Accumulate(const std::vector<PlaneResidual>& residuals, double sigma, const PlaneAlignmentOptions& options) {
  Equations e;
  for (const PlaneResidual& r : residuals) {
    const double size = std::abs(r.value) / sigma;
    const double weight = (size <= options.huber ? 1 : options.huber / size) / (sigma * sigma);
    Vector11 row;
    row << r.row.transpose(), options.photometric ? -r.reference : 0, options.photometric ? -1 : 0;
    e.H.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    e.g -= weight * r.value * row;
  }
  e.H = Matrix11(e.H.selfadjointView<Eigen::Lower>());
  return e;
}

/// Information matrix of n_d, whose length is one over the distance and whose direction is the normal's.
Eigen::Matrix3d NormalInformation(const Eigen::Vector3d& normal_d, const PlanePrior& prior) {
  const double length = normal_d.norm();
  const Eigen::Vector3d n = normal_d / length;
  const Eigen::Matrix3d along = n * n.transpose();
  return (along / std::pow(prior.distance_sigma, 2) +
          (Eigen::Matrix3d::Identity() - along) / std::pow(prior.tilt_sigma_rad, 2)) /
         (length * length);
}

void AddPrior(const PlaneState& state, const PlaneState& guess, const PlanePrior& prior, const PlaneResiduals& level,
              Equations& e) {
  const Eigen::Vector3d z = level.M_inverse() * state.normal_d;
  const Eigen::Matrix3d J = level.M() * z.asDiagonal(), information = NormalInformation(guess.normal_d, prior);
  e.H.block<3, 3>(6, 6) += J.transpose() * information * J;
  e.g.segment<3>(6) -= J.transpose() * information * (state.normal_d - guess.normal_d);
  Vector6d weight;
  weight << Eigen::Vector3d::Constant(std::pow(prior.translation_sigma_m, -2)),
      Eigen::Vector3d::Constant(std::pow(prior.rotation_sigma_rad, -2));
  e.H.diagonal().head<6>() += weight;
  e.g.head<6>() -= weight.cwiseProduct(LogSe3(guess.X_CR.Inverse() * state.X_CR));
  constexpr double kGainSigma = 0.3, kOffsetSigma_grey = 30;  // brightness changes by some 10 % between frames
  e.H(9, 9) += std::pow(kGainSigma, -2);
  e.g(9) -= std::pow(kGainSigma, -2) * (state.gain - guess.gain);
  e.H(10, 10) += std::pow(kOffsetSigma_grey, -2);
  e.g(10) -= std::pow(kOffsetSigma_grey, -2) * (state.offset - guess.offset);
}

PlaneState Updated(const PlaneState& state, const Eigen::Matrix3d& M, const Vector11& step) {
  PlaneState updated = state;
  updated.X_CR = state.X_CR * ExpSe3(step.head<6>());
  const Eigen::Vector3d z = (M.inverse() * state.normal_d).cwiseProduct(step.segment<3>(6).array().exp().matrix());
  updated.normal_d = M * z;  // Eqs. 6.15, 6.16
  updated.gain += step(9);
  updated.offset += step(10);
  return updated;
}

void Describe(const std::vector<PlaneResidual>& residuals, size_t points, double sigma, PlaneAlignment& result) {
  result.residual_grey = sigma;
  result.inside_ratio = points == 0 ? 0 : double(residuals.size()) / double(points);
  result.inliers = int(std::count_if(residuals.begin(), residuals.end(),
                                     [&](const PlaneResidual& r) { return std::abs(r.value) < 3 * sigma; }));
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  Eigen::Array3d products = Eigen::Array3d::Zero();
  for (const PlaneResidual& r : residuals) {
    const double a = r.reference, b = r.value + result.state.gain * r.reference + result.state.offset;
    sum += Eigen::Array2d(a, b);
    products += Eigen::Array3d(a * a, b * b, a * b);
  }
  const double n = double(residuals.size());
  const double aa = products[0] - sum[0] * sum[0] / n, bb = products[1] - sum[1] * sum[1] / n;
  result.correlation = aa > 0 && bb > 0 ? (products[2] - sum[0] * sum[1] / n) / std::sqrt(aa * bb) : 0;
}

void DescribeCovariance(const Equations& e, const PlaneState& state, const Eigen::Matrix3d& M, PlaneAlignment& result) {
  const Matrix11 covariance = InverseOfSymmetric(e.H);
  const Eigen::Matrix3d J = M * (M.inverse() * state.normal_d).asDiagonal();
  result.motion_covariance = covariance.topLeftCorner<6, 6>();
  result.normal_covariance = J * covariance.block<3, 3>(6, 6) * J.transpose();
}

}  // namespace

PlaneAligner::PlaneAligner(const CameraModel& camera, const PlaneAlignmentOptions& options)
    : camera_(camera), options_(options) {
  camera.Check();
  CheckFields(options, "plane_alignment.");
}

PlaneReference PlaneAligner::MakeReference(const cv::Mat& image, const cv::Mat& mask) const {
  GAITCAM_ASSERT(mask.type() == CV_8UC1 && mask.size() == image.size());
  PlaneReference reference{MakePyramid(image), {}, BlurMotion::Zero()};
  for (size_t k = 0; k < reference.pyramid.levels.size(); ++k) {
    reference.points.push_back(SelectPixels(reference.pyramid.levels[k], mask, k, size_t(options_.max_points)));
  }
  return reference;
}

PlaneAlignment PlaneAligner::Align(const PlaneReference& reference, const ImagePyramid& current,
                                   const PlaneState& guess, const PlanePrior& prior, const CurrentBlur& blur) const {
  GAITCAM_ASSERT(reference.pyramid.levels.size() == current.levels.size());
  constexpr size_t kMinPoints = 30;  // some three per unknown
  constexpr double kMiddleGrey = 128, kBrightnessStep_grey = 0.2;
  PlaneAlignment result;
  result.state = guess;
  for (size_t k = current.levels.size(); k-- > 0;) {
    const PlaneResiduals level(camera_, options_.max_blur_samples, reference, current, k, blur);
    if (level.points() < kMinPoints && k > 0) continue;  // too few pixels at this level
    for (int i = 0; i < options_.max_iterations; ++i, ++result.iterations) {
      const std::vector<PlaneResidual> residuals = level.At(result.state);
      if (residuals.size() < kMinPoints) return result;
      const double sigma = std::max(options_.noise_grey, RobustSigma(residuals));
      Describe(residuals, level.points(), sigma, result);
      Equations equations = Accumulate(residuals, sigma, options_);
      AddPrior(result.state, guess, prior, level, equations);
      const Vector11 step = SolveSymmetric(equations.H, equations.g);
      if (!step.allFinite()) return result;
      const PlaneState updated = Updated(result.state, level.M(), step);
      const double moved_px = level.Displacement_px(result.state, step.head<9>());
      if (k == 0) DescribeCovariance(equations, result.state, level.M(), result);
      result.state = updated;
      const double brightened_grey = std::abs(kMiddleGrey * step(9) + step(10));
      if (moved_px < options_.step_px && brightened_grey < kBrightnessStep_grey) break;
    }
  }
  result.converged = result.residual_grey <= options_.max_residual_grey &&
                     result.inside_ratio >= options_.min_inside_ratio && result.state.gain > 0;
  return result;
}

}  // namespace gaitcam
