#include "algorithms/planes/floor_filter.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/estimation/resampling.h"

namespace gaitcam {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTail = 3;  // c of rho: beyond so many standard deviations a point hardly counts
double Rho(double e) { return kTail * kTail * std::log1p(e * e / (kTail * kTail)); }
double RhoWeight(double e) { return 1 / (1 + e * e / (kTail * kTail)); }
/// A worse mean over the points is no match.
const double kWorstRho = Rho(1.5);

/// A keyframe's picture compared with earlier ones from one place.
struct Comparison {
  Matrix5 H = Matrix5::Zero();  ///< Of (x, y, yaw in the pose's frame, gain, offset).
  Vector5 g = Vector5::Zero();  ///< Downhill.
  double mean_rho = 0;
  double correlation = 0;
  int points = 0;
};

/// An earlier picture, ready to be looked up in from the world.
struct Lookup {
  const FloorPatch::Level* patch;
  PlanarPose inverse;
  Eigen::Matrix2f R;  ///< Of its slopes into the world.
};

/// Mean of what the earlier pictures show at a place.
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

Comparison Compare(const std::vector<Lookup>& known, const FloorPatch::Level& patch, const PlanarPose& pose,
                   double gain, double offset, double noise_grey) {
  Comparison comparison;
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  Eigen::Array3d products = Eigen::Array3d::Zero();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(pose.heading).toRotationMatrix();
  for (const FloorPatch::Point& point : patch.match) {
    const std::optional<FloorPatch::Sample> there = LookUp(known, pose.position + R * point.p);
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
    ++comparison.points;
    const double a = point.intensity, b = there->intensity;
    sum += Eigen::Array2d(a, b);
    products += Eigen::Array3d(a * a, b * b, a * b);
  }
  const double n = std::max(1, comparison.points);
  const double aa = products[0] - sum[0] * sum[0] / n, bb = products[1] - sum[1] * sum[1] / n;
  comparison.correlation = aa > 0 && bb > 0 ? (products[2] - sum[0] * sum[1] / n) / std::sqrt(aa * bb) : 0;
  comparison.H = Matrix5(comparison.H.selfadjointView<Eigen::Lower>());
  comparison.mean_rho /= std::max(1, comparison.points);
  return comparison;
}

/// What the tracker says of a motion, and what no tracker is better than.
Eigen::Matrix3d MotionCovariance(const FloorFilterOptions& options, double moved_m, const Eigen::Matrix3d& tracked) {
  const double least_m = options.drift_ratio * moved_m + 1e-5;
  const double least_rad = options.drift_deg_per_m * kDegree * moved_m + 1e-5;
  Eigen::Matrix3d Q = std::pow(options.inflation, 2) * tracked;
  Q.diagonal() += Eigen::Vector3d(least_m, least_m, least_rad).cwiseAbs2();
  return Q;
}

}  // namespace

FloorFilter::FloorFilter(const FloorFilterOptions& options, uint64_t seed)
    : options_(options), random_(seed, "floor_filter") {
  CheckFields(options, "floor_filter.");
  particles_.assign(size_t(options.particles), {});
}

/// The nearest of the pictures that the particle took long enough ago and that lie about where it looks now.
std::vector<FloorFilter::Known> FloorFilter::FindKnown(const Particle& particle, const PlanarPose& expected,
                                                       const FloorPatch& patch) const {
  const Eigen::Vector2d here = expected * patch.middle;
  const double reach_m = 0.5 * patch.width_m();
  std::vector<std::pair<double, Known>> near;
  for (size_t step = 0; step < particle.path.size(); ++step) {
    if (way_m_.back() - way_m_[step] < options_.loop_m) break;
    const PlanarPose& pose = particle.path[step];
    if ((pose.position - here).squaredNorm() > 9 * reach_m * reach_m || patches_[step].empty()) continue;
    const double distance_m = (pose * patches_[step].middle - here).norm();
    if (distance_m < reach_m) near.push_back({distance_m, {&patches_[step], pose, int(step)}});
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Known> known;
  for (size_t i = 0; i < std::min(near.size(), size_t(options_.pictures)); ++i) known.push_back(near[i].second);
  return known;
}

/// Gauss-Newton from the expected pose to where the pictures agree best, coarse ones first; nothing if too few points
/// are known or no place nearby agrees.
std::optional<FloorFilter::Match> FloorFilter::MatchPictures(const std::vector<Known>& pictures,
                                                             const PlanarPose& expected,
                                                             const FloorPatch& patch) const {
  constexpr int kIterations = 6;
  constexpr double kGainSigma = 0.2, kOffsetSigma_grey = 20, kStep_m = 2e-4;
  constexpr double kWindow_m = 0.05, kWindow_rad = 0.05;  // where to search, softly
  Vector5 window;
  window << kWindow_m, kWindow_m, kWindow_rad, kGainSigma, kOffsetSigma_grey;
  const Matrix5 prior = window.cwiseAbs2().cwiseInverse().asDiagonal();
  const Vector5 start(0, 0, 0, 1, 0);
  Vector5 state = start;
  Comparison comparison;
  Matrix5 H;
  const auto pose = [&] { return expected * PlanarPose{state.head<2>(), state[2]}; };
  for (int level = FloorPatch::kLevels - 1; level >= 0; level -= 2) {
    std::vector<Lookup> known;
    for (const Known& k : pictures) {
      known.push_back({&k.patch->levels[size_t(level)], k.pose.Inverse(),
                       Eigen::Rotation2Df(float(k.pose.heading)).toRotationMatrix()});
    }
    for (int i = 0; i < kIterations; ++i) {
      comparison = Compare(known, patch.levels[size_t(level)], pose(), state[3], state[4], options_.noise_grey);
      if (comparison.points < options_.min_match_points >> level) return std::nullopt;
      H = options_.independent * comparison.H + prior;
      const Vector5 step = H.ldlt().solve(options_.independent * comparison.g - prior * (state - start));
      state += step;
      if (step.head<2>().norm() < kStep_m && std::abs(step[2]) < kStep_m) break;
    }
  }
  Match match;
  match.moved = state.head<3>();
  match.covariance = H.inverse().topLeftCorner<3, 3>();
  match.covariance.diagonal() +=
      Eigen::Vector3d(std::pow(options_.match_sigma_m, 2), std::pow(options_.match_sigma_m, 2),
                      std::pow(options_.match_sigma_deg * kDegree, 2));
  match.points = comparison.points;
  match.mean_rho = comparison.mean_rho;
  match.correlation = comparison.correlation;
  return match;
}

/// The tracked motion's Gaussian times the likelihood's.
FloorFilter::Proposal FloorFilter::Propose(const Particle& particle, const PlanarPose& expected,
                                           const Eigen::Matrix3d& Q, const FloorPatch& patch) const {
  Proposal proposal;
  proposal.pose = expected;
  proposal.covariance = Q;
  if (patch.empty()) return proposal;
  const std::vector<Known> pictures = FindKnown(particle, expected, patch);
  if (pictures.empty()) return proposal;
  const std::optional<Match> match = MatchPictures(pictures, expected, patch);
  if (!match) return proposal;
  proposal.points = match->points;
  proposal.log_likelihood = -0.5 * std::min(match->mean_rho, kWorstRho);
  if (match->mean_rho >= kWorstRho || match->correlation < options_.min_correlation) return proposal;
  const Eigen::Matrix3d both = Q + match->covariance;
  const Eigen::Matrix3d gain = Q * both.inverse();  // as Kalman's
  const Eigen::Vector3d moved = gain * match->moved;
  proposal.pose = expected * PlanarPose{moved.head<2>(), moved[2]};
  const Eigen::Matrix3d rest = (Eigen::Matrix3d::Identity() - gain) * Q;
  proposal.covariance = 0.5 * (rest + rest.transpose());
  proposal.log_prior = -0.5 * match->moved.dot(both.inverse() * match->moved) +
                       0.5 * std::log(match->covariance.determinant() / both.determinant());
  const PlanarPose matched = expected * PlanarPose{match->moved.head<2>(), match->moved[2]};
  const Known& nearest = pictures.front();
  proposal.loop =
      FloorLoop{int(particle.path.size()), nearest.step, nearest.pose.Inverse() * matched, match->covariance};
  return proposal;
}

/// Particles may know more or less of what is seen: their likelihoods per point are compared as if all knew as much as
/// the middle one. One that knows too little is taken for no better than the worst.
void FloorFilter::Reweigh(const std::vector<Proposal>& proposals) {
  std::vector<int> points;
  for (const Proposal& proposal : proposals) {
    if (proposal.points > 0) points.push_back(proposal.points);
  }
  if (points.empty()) return;
  const double counted = options_.independent * UpperMedian(points);
  const auto mass = [&](const Proposal& p) { return counted * p.log_likelihood + p.log_prior; };
  double worst = std::numeric_limits<double>::max();
  for (const Proposal& proposal : proposals) {
    if (proposal.points > 0) worst = std::min(worst, mass(proposal));
  }
  for (size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].log_weight += proposals[i].points > 0 ? mass(proposals[i]) : worst;
  }
}

void FloorFilter::Move(Particle& particle, const Proposal& proposal) {
  const Eigen::Matrix3d L = proposal.covariance.llt().matrixL();
  const double nx = random_.Normal(), ny = random_.Normal(), nyaw = random_.Normal();
  const Eigen::Vector3d drawn = L * Eigen::Vector3d(nx, ny, nyaw);
  if (proposal.loop) particle.loops.push_back(*proposal.loop);
  particle.path.push_back(proposal.pose * PlanarPose{drawn.head<2>(), drawn[2]});
}

void FloorFilter::Step(const PlanarPose& motion, const Eigen::Matrix3d& covariance, FloorPatch patch) {
  const double moved_m = motion.position.norm();
  way_m_.push_back((way_m_.empty() ? 0 : way_m_.back()) + moved_m);
  const Eigen::Matrix3d Q = MotionCovariance(options_, moved_m, covariance);
  std::vector<Proposal> proposals;
  corrected_ = 0;
  for (Particle& particle : particles_) {
    const PlanarPose expected = (particle.path.empty() ? PlanarPose() : particle.path.back()) * motion;
    proposals.push_back(Propose(particle, expected, Q, patch));
    corrected_ += proposals.back().loop.has_value();
    Move(particle, proposals.back());
  }
  const int step = int(patches_.size());
  motions_.push_back({step - 1, step, motion, Q});
  patches_.push_back(std::move(patch));
  Reweigh(proposals);
  Resample();
}

void FloorFilter::Resample() {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  const std::vector<double> weights = NormalisedWeights(logs);
  effective_ = EffectiveSampleSize(weights);
  if (effective_ >= options_.resample_ratio * double(particles_.size())) return;
  std::vector<Particle> next;
  for (const int i : LowVarianceResample(weights, int(particles_.size()), random_)) {
    next.push_back(particles_[size_t(i)]);
    next.back().log_weight = 0;
  }
  particles_ = std::move(next);
}

const FloorFilter::Particle& FloorFilter::Best() const {
  return *std::max_element(particles_.begin(), particles_.end(),
                           [](const Particle& a, const Particle& b) { return a.log_weight < b.log_weight; });
}

PlanarPose FloorFilter::Mean() const {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  const std::vector<double> weights = NormalisedWeights(logs);
  PlanarPose mean;
  Eigen::Vector2d heading = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < particles_.size(); ++i) {
    const PlanarPose pose = particles_[i].path.empty() ? PlanarPose() : particles_[i].path.back();
    mean.position += weights[i] * pose.position;
    heading += weights[i] * Eigen::Vector2d(std::cos(pose.heading), std::sin(pose.heading));
  }
  mean.heading = std::atan2(heading.y(), heading.x());
  return mean;
}

Eigen::Matrix3d FloorFilter::Covariance() const {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  const std::vector<double> weights = NormalisedWeights(logs);
  const PlanarPose mean = Mean();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < particles_.size(); ++i) {
    const PlanarPose pose = particles_[i].path.empty() ? PlanarPose() : particles_[i].path.back();
    Eigen::Vector3d off;
    off << pose.position - mean.position, WrapAngle(pose.heading - mean.heading);
    covariance += weights[i] * off * off.transpose();
  }
  return covariance;
}

std::vector<PlanarPose> FloorFilter::SmoothPath() const {
  const std::vector<PlanarPose> start = BestPath();
  if (start.size() < 2) return start;
  std::vector<PlanarEdge> edges(motions_.begin() + 1, motions_.end());
  for (const FloorLoop& loop : BestLoops()) {
    edges.push_back({loop.earlier, loop.keyframe, loop.motion, loop.covariance, true});
  }
  return SolvePlanarGraph(start, edges);
}

FloorPicture FloorFilter::Map(const std::vector<PlanarPose>& path) const {
  return DrawFloor(patches_, path, options_.cell_m);
}

double FloorFilter::map_bytes() const {
  double bytes = 0;
  for (const FloorPatch& patch : patches_) bytes += patch.bytes();
  for (const Particle& particle : particles_) {
    bytes += double(particle.path.capacity() * sizeof(PlanarPose) + particle.loops.capacity() * sizeof(FloorLoop));
  }
  return bytes;
}

}  // namespace gaitcam
