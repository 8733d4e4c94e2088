#include "algorithms/planes/floor_match.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "algorithms/core/small_solvers.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

using Vector5 = FloorAgreement::Vector5;
using Matrix5 = FloorAgreement::Matrix5;

constexpr double kTail = 3;  // c of rho
double Rho(double e) { return kTail * kTail * std::log1p(e * e / (kTail * kTail)); }
double RhoWeight(double e) { return 1 / (1 + e * e / (kTail * kTail)); }

/// An earlier patch, prepared for looking up world positions.
struct Lookup {
  const FloorPatch::Level* patch;
  PlanarMotion inverse;
  Eigen::Matrix2f R;  ///< Rotates its slopes into the world.
};

/// Mean of the earlier patches at a position.
std::optional<FloorPatch::Sample> LookUp(const std::vector<Lookup>& known, const Eigen::Vector2d& p) {
  FloorPatch::Sample sum;
  int count = 0;
  for (const Lookup& earlier : known) {
    const std::optional<FloorPatch::Sample> sample = earlier.patch->At(earlier.inverse * p);
    if (!sample) continue;
    sum.intensity += sample->intensity;
    sum.slope += earlier.R * sample->slope;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return FloorPatch::Sample{sum.intensity / float(count), sum.slope / float(count)};
}

}  // namespace

FloorAgreement AgreementOf(const std::vector<KnownFloor>& known, const FloorPatch& patch, int level,
                           const PlanarPose& pose, double gain, double offset, double noise_grey) {
  std::vector<Lookup> lookups;
  for (const KnownFloor& k : known) {
    lookups.push_back({&k.patch->levels[size_t(level)], PlanarMotion(k.pose.Inverse()),
                       Eigen::Rotation2Df(float(k.pose.heading)).toRotationMatrix()});
  }
  FloorAgreement comparison;
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  Eigen::Array3d products = Eigen::Array3d::Zero();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(pose.heading).toRotationMatrix();
  for (const FloorPatch::Point& point : patch.levels[size_t(level)].match) {
    const std::optional<FloorPatch::Sample> there = LookUp(lookups, pose.position + R * point.p);
    if (!there) continue;
    const double e = (point.intensity - (gain * there->intensity + offset)) / noise_grey;
    const Eigen::RowVector2d slope = gain * there->slope.cast<double>().transpose() * R;
    Vector5 J;
    J << slope.x(), slope.y(), slope.y() * point.p.x() - slope.x() * point.p.y(), there->intensity, 1;
    J /= noise_grey;
    const double weight = RhoWeight(e);
    comparison.H.selfadjointView<Eigen::Lower>().rankUpdate(J, weight);
    comparison.g += weight * e * J;
    comparison.mean_rho += Rho(e);
    comparison.mean_square += e * e;
    ++comparison.points;
    const double a = point.intensity, b = there->intensity;
    sum += Eigen::Array2d(a, b);
    products += Eigen::Array3d(a * a, b * b, a * b);
  }
  const double n = std::max(1, comparison.points);
  const double aa = products[0] - sum[0] * sum[0] / n, bb = products[1] - sum[1] * sum[1] / n;
  comparison.correlation = aa > 0 && bb > 0 ? (products[2] - sum[0] * sum[1] / n) / std::sqrt(aa * bb) : 0;
  comparison.H = Matrix5(comparison.H.selfadjointView<Eigen::Lower>());
  comparison.mean_rho /= n;
  comparison.mean_square /= n;
  return comparison;
}

double WorstMeanRho() { return Rho(1.5); }

std::optional<FloorMatch> MatchFloor(const std::vector<KnownFloor>& known, const FloorPatch& patch,
                                     const PlanarPose& expected, const FloorMatchOptions& options) {
  constexpr int kIterations = 6;
  constexpr double kGainSigma = 0.2, kOffsetSigma_grey = 20, kStep_m = 2e-4;
  constexpr double kWindow_m = 0.05, kWindow_rad = 0.05;  // standard deviations of the prior about the expected pose
  Vector5 window;
  window << kWindow_m, kWindow_m, kWindow_rad, kGainSigma, kOffsetSigma_grey;
  const Matrix5 prior = window.cwiseAbs2().cwiseInverse().asDiagonal();
  const Vector5 start(0, 0, 0, 1, 0);
  Vector5 state = start;
  FloorAgreement comparison;
  Matrix5 H;
  const auto pose = [&] { return expected * PlanarPose{state.head<2>(), state[2]}; };
  for (int level = FloorPatch::kLevels - 1; level >= 0; level -= 2) {
    for (int i = 0; i < kIterations; ++i) {
      comparison = AgreementOf(known, patch, level, pose(), state[3], state[4], options.noise_grey);
      if (comparison.points < options.min_points >> level) return std::nullopt;
      H = options.independent * comparison.H + prior;
      const Vector5 step = SolveSymmetric<5>(H, options.independent * comparison.g - prior * (state - start));
      state += step;
      if (step.head<2>().norm() < kStep_m && std::abs(step[2]) < kStep_m) break;
    }
  }
  FloorMatch match;
  match.moved = state.head<3>();
  match.covariance = Inverse(H).topLeftCorner<3, 3>();
  match.covariance.diagonal() += Eigen::Vector3d(std::pow(options.min_sigma_m, 2), std::pow(options.min_sigma_m, 2),
                                                 std::pow(options.min_sigma_deg * kRadPerDeg, 2));
  match.points = comparison.points;
  match.mean_rho = comparison.mean_rho;
  match.correlation = comparison.correlation;
  return match;
}

}  // namespace gaitcam
