#include "scenarios/code/experiments/stereo_trials.h"

#include <Eigen/Cholesky>
#include <limits>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

Eigen::Vector2d Noise(const Eigen::Matrix2d& covariance, RandomStream& random) {
  const double a = std::sqrt(covariance(0, 0)), b = covariance(0, 1) / a;  // Cholesky's factor
  const double n = random.Normal(), m = random.Normal();
  return {a * n, b * n + std::sqrt(covariance(1, 1) - b * b) * m};
}

}  // namespace

StereoRig ValenciaRig(double baseline_m) {
  const CameraModel camera = CameraModel::FromHorizontalFov(640, 480, 60);
  Vector6d d;
  d << 0.385, 0.007, 0, 0.040, 0.016, 0.014;
  if (baseline_m > 0) d[0] = baseline_m;
  return {camera, camera, PoseOfEuler(d)};
}

Pose StepOfTrials() { return {ExpSo3({0.01, 0.03, -0.02}), {0.03, 0.01, 0.15}}; }

StereoSighting ExactSighting(const StereoRig& rig, const Eigen::Vector3d& p_L, double sigma_px) {
  StereoSighting sighting;
  const auto left = rig.left.Project(p_L), right = rig.right.Project(rig.X_LR.Inverse() * p_L);
  GAITCAM_ASSERT(left && right);
  sighting.left = *left;
  sighting.right = *right;
  sighting.covariance_left = sighting.covariance_right = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  return sighting;
}

StereoSighting WithNoise(const StereoSighting& sighting, RandomStream& random) {
  StereoSighting noisy = sighting;
  noisy.left += Noise(sighting.covariance_left, random);
  noisy.right += Noise(sighting.covariance_right, random);
  return noisy;
}

SceneSightings DrawScene(const StereoRig& rig, const Pose& X_AB, int points, double near_m, double far_m,
                         double sigma_px, RandomStream& random) {
  SceneSightings scene{rig, X_AB, {}, {}};
  const auto seen = [&](const Eigen::Vector3d& p_L) {
    const auto left = rig.left.Project(p_L), right = rig.right.Project(rig.X_LR.Inverse() * p_L);
    return left && right && rig.left.Contains(*left) && rig.right.Contains(*right);
  };
  while (scene.size() < points) {
    const Eigen::Vector2d pixel(random.Uniform(0, rig.left.width_px - 1), random.Uniform(0, rig.left.height_px - 1));
    const Eigen::Vector3d p_A = random.Uniform(near_m, far_m) * rig.left.Unproject(pixel);
    const Eigen::Vector3d p_B = X_AB.Inverse() * p_A;
    if (!seen(p_A) || !seen(p_B)) continue;
    scene.A.push_back(ExactSighting(rig, p_A, sigma_px));
    scene.B.push_back(ExactSighting(rig, p_B, sigma_px));
  }
  return scene;
}

SceneSightings WithNoise(const SceneSightings& scene, RandomStream& random) {
  SceneSightings noisy = scene;
  for (StereoSighting& sighting : noisy.A) sighting = WithNoise(sighting, random);
  for (StereoSighting& sighting : noisy.B) sighting = WithNoise(sighting, random);
  return noisy;
}

template <int N>
double SquaredNorm(const Eigen::Matrix<double, N, 1>& e, const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> cholesky(0.5 * (covariance + covariance.transpose()));
  if (cholesky.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return e.dot(cholesky.solve(e));
}
template double SquaredNorm(const Eigen::Vector3d&, const Eigen::Matrix3d&);
template double SquaredNorm(const Vector6d&, const Matrix6d&);

double PointNeesSum(const StereoRig& rig, const StereoSighting& exact, int samples, RandomStream& random) {
  const StereoPoint point = ReconstructPoint(rig, exact, {StereoCost::kAlgebraic, 0});
  GAITCAM_ASSERT(point.ok());
  const Eigen::Matrix3d information = point.covariance.inverse();
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    const StereoSighting noisy = WithNoise(exact, random);
    const Eigen::Vector3d e = SolveLinearly(rig, noisy.left, noisy.right) - point.p_L;
    sum += e.dot(information * e);
  }
  return sum;
}

SceneSightings Reconstructible(const SceneSightings& scene) {
  SceneSightings kept{scene.rig, scene.X_AB, {}, {}};
  constexpr ReconstructionOptions kAnyDepth{StereoCost::kAlgebraic, 0};
  for (size_t k = 0; k < scene.A.size(); ++k) {
    if (!ReconstructPoint(scene.rig, scene.A[k], kAnyDepth).ok() ||
        !ReconstructPoint(scene.rig, scene.B[k], kAnyDepth).ok())
      continue;
    kept.A.push_back(scene.A[k]);
    kept.B.push_back(scene.B[k]);
  }
  return kept;
}

double MotionNeesSum(const SceneSightings& exact, int samples, RandomStream& random, std::vector<Vector6d>* poses) {
  const SceneSightings kept = Reconstructible(exact);
  const auto points = Reconstruct(kept, {StereoCost::kAlgebraic, 0});
  std::vector<PointMatch> matches = MatchesOf(points);
  GAITCAM_ASSERT(Degeneracy(matches) == RigidMotionStatus::kOk);
  const Pose mu = FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB;
  const Matrix6d to_euler = EulerJacobian(mu);
  const Matrix6d covariance =
      to_euler * PropagateMotion(points, mu, MotionCost::kDistances).covariance * to_euler.transpose();
  const Matrix6d information = covariance.inverse();
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    for (size_t k = 0; k < matches.size(); ++k) {
      const StereoSighting a = WithNoise(kept.A[k], random), b = WithNoise(kept.B[k], random);
      matches[k].p_A = SolveLinearly(kept.rig, a.left, a.right);
      matches[k].p_B = SolveLinearly(kept.rig, b.left, b.right);
    }
    const Vector6d d = EulerOf(FitRigidMotion(matches, RigidMotionMethod::kSvd).X_AB);
    const Vector6d e = d - EulerOf(mu);
    sum += e.dot(information * e);
    if (poses) poses->push_back(d);
  }
  return sum;
}

std::vector<StereoPointMatch> Reconstruct(const SceneSightings& scene, const ReconstructionOptions& options) {
  std::vector<StereoPointMatch> points;
  for (size_t k = 0; k < scene.A.size(); ++k) {
    const StereoPointMatch point{ReconstructPoint(scene.rig, scene.A[k], options),
                                 ReconstructPoint(scene.rig, scene.B[k], options)};
    if (point.A.ok() && point.B.ok()) points.push_back(point);
  }
  return points;
}

std::vector<PointMatch> MatchesOf(const std::vector<StereoPointMatch>& points) {
  std::vector<PointMatch> matches;
  for (const StereoPointMatch& point : points) matches.push_back(point.Match());
  return matches;
}

}  // namespace gaitcam
