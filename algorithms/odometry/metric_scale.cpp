#include "algorithms/odometry/metric_scale.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gaitcam {
namespace {

constexpr int kLatestKeyframes = 10;         // keyframes since a landmark was first seen
constexpr int kMinLandmarks = 25;            // on the floor
constexpr double kMaxDepthSigma = 0.2;       // relative
constexpr double kMinDescent = 0.1;          // sine of the angle below the horizon
constexpr double kBobbing = 0.015;           // relative, of one keyframe: the walk's bobbing
constexpr double kGravitySigma_rad = 0.015;  // of `up_W`
constexpr double kIndependent = 12;          // landmarks: an error of a keyframe's pose is common to all that it saw
constexpr double kMaxSigmas = 3;             // of an inlier
constexpr double kDriftSigma = 0.004;        // of the logarithm of a map's unit, from one keyframe to the next
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A landmark, its depth as its observations alone have it.
struct Candidate {
  Eigen::Vector3d ray_W;  ///< r of equation 1: from Carried::at_W.
  double length = 0;      ///< Of ray_W.
  double rho = 0, sigma = 0;
  bool is_seen_now = false;  ///< By the latest keyframe.
};

std::vector<Candidate> CandidatesOf(const KeyframeMap& map, const Carried& carried) {
  const Eigen::Vector3d& up_W = carried.up_W;
  std::vector<Candidate> candidates;
  const int newest = int(map.keyframes().size()) - 1;
  for (const Landmark& landmark : map.landmarks()) {
    if (landmark.observations.empty() || newest - landmark.anchor > kLatestKeyframes || !(landmark.rho > 0)) continue;
    const double total = 1 / (landmark.rho_sigma * landmark.rho_sigma),
                 prior = 1 / (landmark.prior_sigma * landmark.prior_sigma), seen = total - prior;
    if (!(seen > 0)) continue;
    // Bundle adjustment gives the prior Cauchy's weight.
    const double off = landmark.rho - landmark.prior_rho, weight = 1 / (1 + off * off * prior);
    Candidate candidate;
    const Pose& anchor = map.keyframes()[size_t(landmark.anchor)];
    candidate.ray_W = anchor.rotation * landmark.ray.homogeneous();
    candidate.rho = landmark.rho + weight * prior / seen * off;
    candidate.sigma = 1 / std::sqrt(seen);
    candidate.is_seen_now = landmark.last_keyframe == newest;
    candidate.ray_W += candidate.rho * (anchor.translation - carried.at_W);
    candidate.length = candidate.ray_W.norm();
    const bool below = -up_W.dot(candidate.ray_W) > kMinDescent * candidate.length;
    if (below && candidate.sigma < kMaxDepthSigma * candidate.rho) candidates.push_back(candidate);
  }
  return candidates;
}

/// Equation 1 for one landmark: what is off, and the standard deviation that is to be expected of it.
struct Residual {
  double value = 0, sigma = 0;
};
Residual ResidualOf(const Candidate& candidate, const Eigen::Vector3d& m, double tilt_sigma) {
  const double expected = -m.dot(candidate.ray_W);
  const double tilt = tilt_sigma * m.norm() * candidate.length;
  return {candidate.rho - expected,
          std::sqrt(candidate.sigma * candidate.sigma + std::pow(kBobbing * expected, 2) + tilt * tilt)};
}

std::vector<int> InliersOf(const std::vector<Candidate>& candidates, const Eigen::Vector3d& m, double tilt_sigma) {
  std::vector<int> inliers;
  for (int i = 0; i < int(candidates.size()); ++i) {
    const Residual residual = ResidualOf(candidates[size_t(i)], m, tilt_sigma);
    if (std::abs(residual.value) < kMaxSigmas * residual.sigma) inliers.push_back(i);
  }
  return inliers;
}

/// The level plane through one of the landmarks that most others agree with, few being below.
std::optional<Eigen::Vector3d> LevelFloor(const std::vector<Candidate>& candidates, const Eigen::Vector3d& up_W) {
  std::optional<Eigen::Vector3d> best;
  double best_score = 0;
  for (const Candidate& through : candidates) {
    const Eigen::Vector3d m = through.rho / -up_W.dot(through.ray_W) * up_W;
    double score = 0;
    int on = 0, below = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (score + double(candidates.size() - i) < best_score) break;  // each adds 1 at most
      const Residual residual = ResidualOf(candidates[i], m, kGravitySigma_rad);
      const double off = residual.value / residual.sigma;
      if (std::abs(off) < kMaxSigmas) {
        ++on;
        score += 1 - off * off / (kMaxSigmas * kMaxSigmas);
      }
      below += off < -kMaxSigmas;
    }
    constexpr int kPerOneBelow = 4;
    if (score > best_score && on >= kMinLandmarks && on >= kPerOneBelow * below) {
      best_score = score;
      best = m;
    }
  }
  return best;
}

}  // namespace

void CarriedMean::Add(int64_t stamp_ns, const Eigen::Vector3d& up_W, const Eigen::Vector3d& at_W) {
  constexpr double kTime_ns = 2e9;
  const double most = frames_ == 0 ? 1 : std::max(1.0, std::round(kTime_ns / double(stamp_ns - stamp_ns_)));
  frames_ = int(std::min(frames_ + 1.0, most));
  stamp_ns_ = stamp_ns;
  const double gain = 1.0 / frames_;
  mean_.up_W = ((1 - gain) * mean_.up_W + gain * up_W).normalized();
  mean_.at_W = (1 - gain) * mean_.at_W + gain * at_W;
}

std::optional<CarriedHeight> MeasureCarriedHeight(const KeyframeMap& map, const Carried& carried) {
  const Eigen::Vector3d& up_W = carried.up_W;
  const std::vector<Candidate> candidates = CandidatesOf(map, carried);
  std::optional<Eigen::Vector3d> m = LevelFloor(candidates, up_W);
  if (!m) return {};
  const Eigen::Matrix3d level = Eigen::Matrix3d::Identity() - up_W * up_W.transpose();
  Eigen::Matrix3d information;
  double tilt_sigma = kGravitySigma_rad;
  std::vector<int> inliers;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    inliers = InliersOf(candidates, *m, tilt_sigma);
    if (int(inliers.size()) < kMinLandmarks) return {};
    information = level / std::pow(kGravitySigma_rad * m->norm(), 2);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const int i : inliers) {
      const Candidate& candidate = candidates[size_t(i)];
      const Residual residual = ResidualOf(candidate, *m, 0);
      const double share = std::min(1.0, kIndependent / double(inliers.size()));
      const double weight = share / (residual.sigma * residual.sigma);
      information += weight * candidate.ray_W * candidate.ray_W.transpose();
      right -= weight * candidate.rho * candidate.ray_W;
    }
    m = information.ldlt().solve(right);
    tilt_sigma = kGravitySigma_rad / 3;  // what the fit leaves
  }
  if (!(m->norm() > 0)) return {};
  CarriedHeight result;
  result.normal_W = m->normalized();
  result.height = 1 / m->norm();
  for (const int i : inliers) {
    const Candidate& candidate = candidates[size_t(i)];
    if (candidate.is_seen_now) result.seen_on_floor_W.emplace_back(carried.at_W + candidate.ray_W / candidate.rho);
  }
  constexpr double kLeastSigma = 0.01;
  const double variance =
      result.normal_W.dot(information.ldlt().solve(result.normal_W)) * result.height * result.height;
  result.relative_sigma = std::hypot(kLeastSigma, std::sqrt(variance));
  return result;
}

void MetricScale::Add(const std::optional<CarriedHeight>& measured, bool new_map) {
  constexpr double kShared = 5;  // keyframes in a row measure the same landmarks
  Keyframe keyframe{new_map || keyframes_.empty(), {0, kInfinity}};
  if (!keyframe.begins_map) {
    keyframe.filtered = keyframes_.back().filtered;
    keyframe.filtered.variance += kDriftSigma * kDriftSigma;
  }
  if (measured) {
    const double z = std::log(height_m_ / measured->height), variance = kShared * std::pow(measured->relative_sigma, 2);
    Belief& belief = keyframe.filtered;
    const double gain = std::isinf(belief.variance) ? 1 : belief.variance / (belief.variance + variance);
    belief = {belief.mean + gain * (z - belief.mean), gain * variance};
  }
  keyframes_.push_back(keyframe);
}

std::optional<double> MetricScale::latest() const {
  constexpr double kMaxSigma = 0.08;
  if (keyframes_.empty() || !(keyframes_.back().filtered.variance < kMaxSigma * kMaxSigma)) return std::nullopt;
  return std::exp(keyframes_.back().filtered.mean);
}

/// The means of Rauch, Tung and Striebel's smoother of a random walk. Before a map's first measurement the best guess
/// is what comes after; a map that has none takes what was known last.
std::vector<double> MetricScale::Smoothed() const {
  const size_t n = keyframes_.size();
  std::vector<Belief> smoothed(n);
  for (size_t k = n; k-- > 0;) {
    smoothed[k] = keyframes_[k].filtered;
    if (k + 1 == n || keyframes_[k + 1].begins_map) continue;
    const Belief &now = keyframes_[k].filtered, &next = smoothed[k + 1];
    const double gain = std::isinf(now.variance) ? 1 : now.variance / (now.variance + kDriftSigma * kDriftSigma);
    smoothed[k].mean += gain * (next.mean - now.mean);
    smoothed[k].variance = std::min(now.variance, next.variance);  // finite exactly where the map was measured
  }
  std::vector<double> scales;
  for (size_t k = 0; k < n; ++k) {
    const double before = k == 0 ? 1 : scales.back();
    scales.push_back(std::isinf(smoothed[k].variance) ? before : std::exp(smoothed[k].mean));
  }
  return scales;
}

}  // namespace gaitcam
