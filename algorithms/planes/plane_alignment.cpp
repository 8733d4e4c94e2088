#include "algorithms/planes/plane_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"

namespace gaitcam {
namespace {

using Matrix11 = Eigen::Matrix<double, 11, 11>;
using Vector11 = Eigen::Matrix<double, 11, 1>;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Vector2d ToPixel(const CameraModel& camera, double scale, const Eigen::Vector3d& p) {
  return {(camera.fx * p.x() / p.z() + camera.cx) / scale, (camera.fy * p.y() / p.z() + camera.cy) / scale};
}

Eigen::Vector3d ToRay(const CameraModel& camera, double scale, const Eigen::Vector2d& p) {
  return {(scale * p.x() - camera.cx) / camera.fx, (scale * p.y() - camera.cy) / camera.fy, 1};
}

/// Derivative of the pixel by the point that is seen there.
Eigen::Matrix<double, 2, 3> PixelJacobian(const CameraModel& camera, double scale, const Eigen::Vector3d& p) {
  const double fx = camera.fx / scale, fy = camera.fy / scale, iz = 1 / p.z();
  Eigen::Matrix<double, 2, 3> J;
  J << fx * iz, 0, -fx * p.x() * iz * iz, 0, fy * iz, -fy * p.y() * iz * iz;
  return J;
}

/// What one reference pixel says.
struct Residual {
  double value = 0;                 ///< current - (gain reference + offset), grey levels.
  double reference = 0;             ///< Intensity of the reference there.
  Eigen::Matrix<double, 1, 9> row;  ///< Derivative of `value` by motion and log inverse depths.
};

/// One level of one alignment: everything that stays the same during its iterations.
class Level {
 public:
  Level(const CameraModel& camera, const PlaneAlignmentOptions& options, const PlaneReference& reference,
        const ImagePyramid& current, size_t k, const CurrentBlur& blur)
      : camera_(camera),
        options_(options),
        reference_(reference.pyramid.levels[k]),
        current_(current.levels[k]),
        points_(reference.points[k]),
        reference_blur_(reference.blur),
        blur_(blur),
        scale_(double(1 << k)) {
    const double w = camera.width_px - 1, h = camera.height_px - 1;
    const std::vector<Eigen::Vector3d> corners{ToRay(camera, 1, {0, h}), ToRay(camera, 1, {w, h}),
                                               ToRay(camera, 1, {w / 2, h / 2})};
    M_ = internal::NormalFromInverseDepths(corners);
    M_inverse_ = M_.inverse();
  }

  const Eigen::Matrix3d& M() const { return M_; }
  const Eigen::Matrix3d& M_inverse() const { return M_inverse_; }
  size_t points() const { return points_.size(); }
  std::vector<Residual> Residuals(const PlaneState& state) const;
  /// How far a step of motion and log inverse depths moves the points, root mean square, px of this level.
  double Displacement_px(const PlaneState& state, const Eigen::Matrix<double, 9, 1>& step) const;

 private:
  /// What all points of one iteration share.
  struct Shared {
    Eigen::Matrix3d R, H, Mz;  ///< Mz: derivative of n_d by the logarithms of the inverse depths.
    Eigen::Vector3d t, n_d;
    double gain, offset;
    ExposureMotion blur;
    bool blurred;
  };
  Shared SharedOf(const PlaneState& state) const;
  std::optional<Residual> ResidualAt(const Shared& s, const Eigen::Vector2d& p_R) const;
  std::optional<ImageSample> Average(const PyramidLevel& level, const Eigen::Vector2d& p,
                                     const Eigen::Vector2d& path) const;
  /// How far the point p (camera frame, m) moves in the image during an exposure.
  Eigen::Vector2d Path(const Eigen::Vector3d& p, const ExposureMotion& motion) const;

  const CameraModel& camera_;
  const PlaneAlignmentOptions& options_;
  const PyramidLevel& reference_;
  const PyramidLevel& current_;
  const std::vector<Eigen::Vector2d>& points_;
  const ExposureMotion& reference_blur_;
  const CurrentBlur& blur_;
  double scale_;
  Eigen::Matrix3d M_, M_inverse_;
};

Eigen::Vector2d Level::Path(const Eigen::Vector3d& p, const ExposureMotion& motion) const {
  // First order: the point moves by translation + rotation x point.
  const Eigen::Vector3d velocity = motion.head<3>() + motion.tail<3>().cross(p);
  return PixelJacobian(camera_, scale_, p) * velocity;
}

/// Mean along the path of an exposure, sampled about every second pixel.
std::optional<ImageSample> Level::Average(const PyramidLevel& level, const Eigen::Vector2d& p,
                                          const Eigen::Vector2d& path) const {
  const double length = path.norm();
  const int wanted = length < 0.5 ? 1 : 1 + 2 * int(std::ceil((length - 0.5) / 2));
  const int samples = std::min(wanted, options_.max_blur_samples);
  if (samples == 1) {
    if (!level.Contains(p)) return std::nullopt;
    return level.At(p);
  }
  const Eigen::Vector2d half = 0.5 * path;
  if (!level.Contains(p - half) || !level.Contains(p + half)) return std::nullopt;
  ImageSample sum;
  for (int i = 0; i < samples; ++i) {
    const ImageSample sample = level.At(p + ((i + 0.5) / samples - 0.5) * path);
    sum.intensity += sample.intensity;
    sum.du += sample.du;
    sum.dv += sample.dv;
  }
  const float share = 1.0F / float(samples);
  return ImageSample{sum.intensity * share, sum.du * share, sum.dv * share};
}

Level::Shared Level::SharedOf(const PlaneState& state) const {
  Shared s;
  s.R = state.X_CR.R();
  s.t = state.X_CR.translation;
  s.n_d = state.normal_d;
  s.H = s.R + s.t * s.n_d.transpose();
  s.Mz = M_ * (M_inverse_ * s.n_d).asDiagonal();
  s.gain = state.gain;
  s.offset = state.offset;
  s.blur = blur_.Motion(state.X_CR);
  s.blurred = options_.max_blur_samples > 1 && (!s.blur.isZero() || !reference_blur_.isZero());
  return s;
}

/// A blurred picture of each image is compared: the reference smeared by the current exposure's path, the current one
/// by the reference's. Each then carries both blurs, whichever of them was sharp.
std::optional<Residual> Level::ResidualAt(const Shared& s, const Eigen::Vector2d& p_R) const {
  const Eigen::Vector3d ray = ToRay(camera_, scale_, p_R);
  const double rho = s.n_d.dot(ray);
  if (rho <= 1e-6) return std::nullopt;  // on or above the horizon
  const Eigen::Vector3d p = s.H * ray;   // the point seen, times its inverse depth
  if (p.z() <= 1e-3) return std::nullopt;
  const Eigen::Matrix<double, 2, 3> dpixel = PixelJacobian(camera_, scale_, p);
  Eigen::Matrix2d A = dpixel * s.H.leftCols<2>();  // d p_C / d p_R
  A.col(0) *= scale_ / camera_.fx;
  A.col(1) *= scale_ / camera_.fy;
  if (std::abs(A.determinant()) < 1e-3) return std::nullopt;
  const Eigen::Matrix2d A_inverse = A.inverse();

  Eigen::Vector2d path_C = Eigen::Vector2d::Zero(), path_R = path_C;  // each in the other image
  if (s.blurred) {
    path_C = A_inverse * Path(p / rho, s.blur);
    path_R = A * Path(ray / rho, reference_blur_);
  }
  const std::optional<ImageSample> seen = Average(current_, ToPixel(camera_, scale_, p), path_R);
  const std::optional<ImageSample> expected = Average(reference_, p_R, path_C);
  if (!seen || !expected) return std::nullopt;

  Residual r;
  r.reference = expected->intensity;
  r.value = seen->intensity - (s.gain * r.reference + s.offset);
  // Eq. 6.19: the mean of the two images' gradients, both as functions of the current pixel, is second order.
  const Eigen::RowVector2d gradient = 0.5 * (Eigen::RowVector2d(seen->du, seen->dv) +
                                             s.gain * Eigen::RowVector2d(expected->du, expected->dv) * A_inverse);
  const Eigen::RowVector3d by_point = gradient * dpixel;
  const Eigen::RowVector3d by_point_R = by_point * s.R;
  r.row.head<3>() = rho * by_point_R;
  r.row.segment<3>(3) = ray.cross(by_point_R.transpose()).transpose();
  r.row.tail<3>() = by_point.dot(s.t) * (ray.transpose() * s.Mz);
  return r;
}

std::vector<Residual> Level::Residuals(const PlaneState& state) const {
  const Shared shared = SharedOf(state);
  std::vector<Residual> residuals;
  residuals.reserve(points_.size());
  for (const Eigen::Vector2d& p : points_) {
    if (std::optional<Residual> residual = ResidualAt(shared, p)) residuals.push_back(*residual);
  }
  return residuals;
}

double Level::Displacement_px(const PlaneState& state, const Eigen::Matrix<double, 9, 1>& step) const {
  constexpr size_t kEvery = 16;
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < points_.size(); i += kEvery, ++count) {
    sum += (internal::WarpJacobian(camera_, scale_, state, M_, points_[i]) * step).squaredNorm();
  }
  return count == 0 ? 0 : std::sqrt(sum / double(count));
}

/// 1.4826 times the median of absolute values: the standard deviation of a Gaussian, whatever the outliers.
double RobustSigma(const std::vector<Residual>& residuals) {
  std::vector<double> values;
  values.reserve(residuals.size());
  for (const Residual& r : residuals) values.push_back(std::abs(r.value));
  return 1.4826 * UpperMedian(std::move(values));
}

/// The normal equations of one step: the pixels' and the prior's.
struct Equations {
  Matrix11 H = Matrix11::Zero();
  Vector11 g = Vector11::Zero();
};

Equations Accumulate(const std::vector<Residual>& residuals, double sigma, const PlaneAlignmentOptions& options) {
  Equations e;
  for (const Residual& r : residuals) {
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

/// Information of n_d: its length is one over the distance, its direction the normal's.
Eigen::Matrix3d NormalInformation(const Eigen::Vector3d& normal_d, const PlanePrior& prior) {
  const double length = normal_d.norm();
  const Eigen::Vector3d n = normal_d / length;
  const Eigen::Matrix3d along = n * n.transpose();
  return (along / std::pow(prior.distance_sigma, 2) +
          (Eigen::Matrix3d::Identity() - along) / std::pow(prior.tilt_sigma_rad, 2)) /
         (length * length);
}

void AddPrior(const PlaneState& state, const PlaneState& guess, const PlanePrior& prior, const Level& level,
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
  // Brightness changes by some ten percent at most from one frame to another.
  constexpr double kGainSigma = 0.3, kOffsetSigma_grey = 30;
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

void Describe(const std::vector<Residual>& residuals, size_t points, double sigma, PlaneAlignment& result) {
  result.residual_grey = sigma;
  result.inside_ratio = points == 0 ? 0 : double(residuals.size()) / double(points);
  result.inliers = int(std::count_if(residuals.begin(), residuals.end(),
                                     [&](const Residual& r) { return std::abs(r.value) < 3 * sigma; }));
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  Eigen::Array3d products = Eigen::Array3d::Zero();
  for (const Residual& r : residuals) {
    const double a = r.reference, b = r.value + result.state.gain * r.reference + result.state.offset;
    sum += Eigen::Array2d(a, b);
    products += Eigen::Array3d(a * a, b * b, a * b);
  }
  const double n = double(residuals.size());
  const double aa = products[0] - sum[0] * sum[0] / n, bb = products[1] - sum[1] * sum[1] / n;
  result.correlation = aa > 0 && bb > 0 ? (products[2] - sum[0] * sum[1] / n) / std::sqrt(aa * bb) : 0;
}

void DescribeCovariance(const Equations& e, const PlaneState& state, const Eigen::Matrix3d& M, PlaneAlignment& result) {
  const Matrix11 covariance = e.H.ldlt().solve(Matrix11::Identity());
  const Eigen::Matrix3d J = M * (M.inverse() * state.normal_d).asDiagonal();
  result.motion_covariance = covariance.topLeftCorner<6, 6>();
  result.normal_covariance = J * covariance.block<3, 3>(6, 6) * J.transpose();
}

/// The pixels of largest gradient, spread over the image: every block gives its best one before any gives a second.
std::vector<Eigen::Vector2d> ChoosePoints(const PyramidLevel& level, const cv::Mat& mask, size_t k, size_t most) {
  constexpr float kLeastGradient_grey = 1;  // per pixel; flat ground says nothing
  constexpr int kBlock_px = 8, kMargin_px = 2;
  struct Candidate {
    float strength;
    uint16_t u, v;
    bool operator<(const Candidate& b) const {  // the stronger, then the upper, left one first
      return strength != b.strength ? strength > b.strength : std::pair(v, u) < std::pair(b.v, b.u);
    }
  };
  const int blocks_across = level.width() / kBlock_px + 1;
  std::vector<std::vector<Candidate>> blocks(size_t(blocks_across) * size_t(level.height() / kBlock_px + 1));
  for (int v = kMargin_px; v < level.height() - kMargin_px; ++v) {
    const uchar* inside = mask.ptr<uchar>(std::min(v << k, mask.rows - 1));
    const cv::Vec3f* row = level.samples.ptr<cv::Vec3f>(v);
    for (int u = kMargin_px; u < level.width() - kMargin_px; ++u) {
      if (inside[std::min(u << k, mask.cols - 1)] == 0) continue;
      const float strength = row[u][1] * row[u][1] + row[u][2] * row[u][2];
      if (strength < kLeastGradient_grey * kLeastGradient_grey) continue;
      std::vector<Candidate>& block = blocks[size_t(v / kBlock_px * blocks_across + u / kBlock_px)];
      if (block.empty()) block.reserve(kBlock_px * kBlock_px);
      block.push_back({strength, uint16_t(u), uint16_t(v)});
    }
  }
  std::vector<Eigen::Vector2d> points;
  points.reserve(most);
  std::vector<Candidate> round;
  for (size_t rank = 0; points.size() < most; ++rank) {
    round.clear();
    for (std::vector<Candidate>& block : blocks) {
      if (block.size() <= rank) continue;
      std::iter_swap(block.begin() + long(rank), std::min_element(block.begin() + long(rank), block.end()));
      round.push_back(block[rank]);
    }
    if (round.empty()) break;
    if (round.size() > most - points.size()) {
      std::nth_element(round.begin(), round.begin() + long(most - points.size()), round.end());
      round.resize(most - points.size());
    }
    for (const Candidate& c : round) points.emplace_back(c.u, c.v);
  }
  return points;
}

}  // namespace

Pose ExpSe3(const Vector6d& x) {
  const Eigen::Vector3d w = x.tail<3>();
  const double angle = w.norm(), a2 = angle * angle;
  const Eigen::Matrix3d W = Cross(w);
  // Coefficients of W and W^2 in the matrix that turns the translation part; by their series near zero.
  const double b = angle < 1e-4 ? 0.5 - a2 / 24 : (1 - std::cos(angle)) / a2;
  const double c = angle < 1e-4 ? 1.0 / 6 - a2 / 120 : (angle - std::sin(angle)) / (a2 * angle);
  const Eigen::Quaterniond q(angle < 1e-12 ? Eigen::AngleAxisd::Identity() : Eigen::AngleAxisd(angle, w / angle));
  return {q, (Eigen::Matrix3d::Identity() + b * W + c * W * W) * x.head<3>()};
}

Vector6d LogSe3(const Pose& X) {
  const Eigen::AngleAxisd turn(X.rotation.w() < 0 ? Eigen::Quaterniond(-X.rotation.coeffs()) : X.rotation);
  const Eigen::Vector3d w = turn.angle() * turn.axis();
  const double angle = turn.angle(), a2 = angle * angle;
  const Eigen::Matrix3d W = Cross(w);
  const double c =
      angle < 1e-4 ? 1.0 / 12 + a2 / 720 : (1 - angle * std::sin(angle) / (2 * (1 - std::cos(angle)))) / a2;
  Vector6d x;
  x << (Eigen::Matrix3d::Identity() - 0.5 * W + c * W * W) * X.translation, w;
  return x;
}

ExposureMotion CurrentBlur::Motion(const Pose& X_CR) const {
  if (ratio == 0) return ExposureMotion::Zero();
  ExposureMotion motion = ratio * LogSe3(X_CR * X_RP);
  if (turn) motion.tail<3>() = -*turn;
  return motion;
}

PlaneAligner::PlaneAligner(const CameraModel& camera, const PlaneAlignmentOptions& options)
    : camera_(camera), options_(options) {
  camera.Check();
  CheckFields(options, "plane_alignment.");
}

PlaneReference PlaneAligner::MakeReference(const cv::Mat& image, const cv::Mat& mask) const {
  GAITCAM_ASSERT(mask.type() == CV_8UC1 && mask.size() == image.size());
  PlaneReference reference{MakePyramid(image), {}, ExposureMotion::Zero()};
  for (size_t k = 0; k < reference.pyramid.levels.size(); ++k) {
    reference.points.push_back(ChoosePoints(reference.pyramid.levels[k], mask, k, size_t(options_.max_points)));
  }
  return reference;
}

PlaneAlignment PlaneAligner::Align(const PlaneReference& reference, const ImagePyramid& current,
                                   const PlaneState& guess, const PlanePrior& prior, const CurrentBlur& blur) const {
  GAITCAM_ASSERT(reference.pyramid.levels.size() == current.levels.size());
  constexpr size_t kLeastPoints = 30;  // some three per unknown
  constexpr double kMiddleGrey = 128, kBrightnessStep_grey = 0.2;
  PlaneAlignment result;
  result.state = guess;
  for (size_t k = current.levels.size(); k-- > 0;) {
    const Level level(camera_, options_, reference, current, k, blur);
    if (level.points() < kLeastPoints && k > 0) continue;  // too small a patch up here
    for (int i = 0; i < options_.max_iterations; ++i, ++result.iterations) {
      const std::vector<Residual> residuals = level.Residuals(result.state);
      if (residuals.size() < kLeastPoints) return result;
      const double sigma = std::max(options_.noise_grey, RobustSigma(residuals));
      Describe(residuals, level.points(), sigma, result);
      Equations equations = Accumulate(residuals, sigma, options_);
      AddPrior(result.state, guess, prior, level, equations);
      const Vector11 step = equations.H.ldlt().solve(equations.g);
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

std::optional<Eigen::Vector2d> WarpPixel(const CameraModel& camera, const PlaneState& state,
                                         const Eigen::Vector2d& p_R) {
  const Eigen::Vector3d ray = ToRay(camera, 1, p_R);
  const Eigen::Vector3d p = state.X_CR.R() * ray + state.normal_d.dot(ray) * state.X_CR.translation;
  if (p.z() <= 0) return std::nullopt;
  return ToPixel(camera, 1, p);
}

namespace internal {

Eigen::Matrix3d NormalFromInverseDepths(const std::vector<Eigen::Vector3d>& rays) {
  GAITCAM_ASSERT(rays.size() == 3);
  Eigen::Matrix3d stacked;  // Eq. 6.13: rays' n_d = z
  for (int i = 0; i < 3; ++i) stacked.row(i) = rays[size_t(i)].transpose();
  return stacked.inverse();
}

Eigen::Matrix<double, 2, 9> WarpJacobian(const CameraModel& camera, double level_scale, const PlaneState& state,
                                         const Eigen::Matrix3d& M, const Eigen::Vector2d& p_R) {
  const Eigen::Vector3d ray = ToRay(camera, level_scale, p_R);
  const double rho = state.normal_d.dot(ray);
  const Eigen::Matrix3d R = state.X_CR.R();
  const Eigen::Vector3d z = M.inverse() * state.normal_d;
  Eigen::Matrix<double, 3, 9> J;
  J.leftCols<3>() = rho * R;
  J.middleCols<3>(3) = -R * Cross(ray);
  J.rightCols<3>() = state.X_CR.translation * (ray.transpose() * M * z.asDiagonal());
  return PixelJacobian(camera, level_scale, R * ray + rho * state.X_CR.translation) * J;
}

}  // namespace internal
}  // namespace gaitcam
