#include "algorithms/planes/floor_filter.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/median.h"
#include "algorithms/core/units.h"
#include "algorithms/estimation/resampling.h"
#include "algorithms/planes/floor_search.h"

namespace gaitcam {
namespace {

/// The motion from the nearest keyframe of a match to the matched pose.
FloorLoop LoopOf(int keyframe, const KnownFloor& nearest, const PlanarPose& expected, const FloorMatch& match) {
  const PlanarPose matched = expected * PlanarPose{match.moved.head<2>(), match.moved[2]};
  return {keyframe, nearest.step, nearest.pose.Inverse() * matched, match.correlation, match.covariance};
}

}  // namespace

FloorFilter::FloorFilter(const FloorFilterOptions& options, uint64_t seed)
    : options_(options), random_(seed, "floor_filter") {
  CheckFields(options, "floor_filter.");
  particles_.assign(size_t(options.particles), {});
}

Eigen::Matrix3d FloorFilter::MotionCovariance(double moved_m, const Eigen::Matrix3d& tracked) const {
  const double min_m = options_.drift_ratio * moved_m + 1e-5;
  const double min_rad = options_.drift_deg_per_m * kRadPerDeg * moved_m + 1e-5;
  Eigen::Matrix3d Q = std::pow(options_.inflation, 2) * tracked;
  Q.diagonal() += Eigen::Vector3d(min_m, min_m, min_rad).cwiseAbs2();
  return Q;
}

/// Steps of the present submap that lie at least loop_m back.
FloorFilter::StepRange FloorFilter::MappedSteps() const {
  const Submap* submap = DetachedSubmap();
  const std::vector<double>& length = path_length_m_;
  const auto recent =
      std::find_if(length.begin(), length.end(), [&](double at) { return length.back() - at < options_.loop_m; });
  return {submap ? submap->first_step : 0, int(std::min(recent - length.begin(), std::ptrdiff_t(patches_.size())))};
}

/// The nearest of these steps' patches to what the particle sees now.
std::vector<KnownFloor> FloorFilter::FindKnown(const Particle& particle, const PlanarPose& expected,
                                               const FloorPatch& patch, const StepRange& steps) const {
  const Eigen::Vector2d here = expected * patch.middle;
  const double reach_m = 0.5 * patch.width_m();
  std::vector<std::pair<double, KnownFloor>> near;
  for (int step = steps.begin; step < steps.end; ++step) {
    const PlanarPose& pose = particle.path[size_t(step)];
    const FloorPatch& seen = patches_[size_t(step)];
    if ((pose.position - here).squaredNorm() > 9 * reach_m * reach_m || seen.empty()) continue;
    const double distance_m = (pose * seen.middle - here).norm();
    if (distance_m < reach_m) near.push_back({distance_m, {&seen, pose, step}});
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<KnownFloor> known;
  for (size_t i = 0; i < std::min(near.size(), size_t(options_.pictures)); ++i) known.push_back(near[i].second);
  return known;
}

bool FloorFilter::Agrees(const FloorMatch& match) const {
  return match.mean_rho < WorstMeanRho() && match.correlation >= options_.min_correlation;
}

/// The Gaussian of the tracked motion times that of the likelihood, fused as in a Kalman filter.
FloorFilter::Proposal FloorFilter::Propose(const Particle& particle, const PlanarPose& expected,
                                           const Eigen::Matrix3d& Q, const FloorPatch& patch) const {
  Proposal proposal;
  proposal.pose = expected;
  proposal.covariance = Q;
  if (patch.empty() || options_.weighting != FloorWeighting::kLikelihood) return proposal;
  const std::vector<KnownFloor> known = FindKnown(particle, expected, patch, MappedSteps());
  if (known.empty()) return proposal;
  const std::optional<FloorMatch> match = MatchFloor(known, patch, expected, options_.match);
  if (!match) return proposal;
  proposal.points = match->points;
  proposal.log_likelihood = -0.5 * WorstMeanRho();
  if (!Agrees(*match)) return proposal;
  proposal.log_likelihood = -0.5 * match->mean_rho;
  const Eigen::Matrix3d both = Q + match->covariance;
  const Eigen::Matrix3d gain = Q * both.inverse();
  const Eigen::Vector3d moved = gain * match->moved;
  proposal.pose = expected * PlanarPose{moved.head<2>(), moved[2]};
  const Eigen::Matrix3d rest = (Eigen::Matrix3d::Identity() - gain) * Q;
  proposal.covariance = 0.5 * (rest + rest.transpose());
  proposal.log_prior = -0.5 * match->moved.dot(both.inverse() * match->moved) +
                       0.5 * std::log(match->covariance.determinant() / both.determinant());
  proposal.loop = LoopOf(int(particle.path.size()), known.front(), expected, *match);
  return proposal;
}

/// Particles match different numbers of points: likelihoods per point are compared as if all had matched the median
/// number. A particle that matched too few gets the smallest weight of the others.
void FloorFilter::Reweigh(const std::vector<Proposal>& proposals) {
  if (corrected_ == 0) return;  // without a loop closure there is nothing to weigh
  std::vector<int> points;
  for (const Proposal& proposal : proposals) {
    if (proposal.points > 0) points.push_back(proposal.points);
  }
  if (points.empty()) return;
  const double counted = options_.match.independent * UpperMedian(points);
  const auto mass = [&](const Proposal& p) { return counted * p.log_likelihood + p.log_prior; };
  double worst = std::numeric_limits<double>::max();
  for (const Proposal& proposal : proposals) {
    if (proposal.points > 0) worst = std::min(worst, mass(proposal));
  }
  for (size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].log_weight += proposals[i].points > 0 ? mass(proposals[i]) : worst;
  }
}

/// Eq. 6.22 at the poses drawn, of the last patch. Particles whose map says nothing there get the smallest weight of
/// the others, as in Reweigh(), for a sum over nothing is no agreement.
void FloorFilter::ReweighByDifferences(const StepRange& steps) {
  if (patches_.back().empty()) return;
  const bool as_written = options_.weighting == FloorWeighting::kDifferences;
  std::vector<std::optional<double>> logs;
  double worst = std::numeric_limits<double>::max();
  for (const Particle& particle : particles_) {
    const PlanarPose& pose = particle.path.back();
    const FloorAgreement agreement =
        AgreementOf(FindKnown(particle, pose, patches_.back(), steps), patches_.back(), 0, pose, 1, 0, 1);
    if (agreement.points < options_.match.min_points) {
      logs.emplace_back();
      continue;
    }
    const double mean = std::max(agreement.mean_square, 1.0);  // a grey level's quantisation, at the least
    logs.emplace_back(as_written ? std::log(mean * agreement.points) : -std::log(mean));
    worst = std::min(worst, *logs.back());
  }
  if (worst == std::numeric_limits<double>::max()) return;
  for (size_t i = 0; i < particles_.size(); ++i) particles_[i].log_weight += logs[i].value_or(worst);
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
  path_length_m_.push_back((path_length_m_.empty() ? 0 : path_length_m_.back()) + moved_m);
  const Eigen::Matrix3d Q = MotionCovariance(moved_m, covariance);
  const int step = int(patches_.size());
  const bool guessed = std::sqrt(Q.topLeftCorner<2, 2>().diagonal().maxCoeff()) > options_.joint_m;
  if (guessed) submaps_.push_back({step, Q});
  const Eigen::Matrix3d drawn = guessed ? Eigen::Matrix3d(1e-12 * Eigen::Matrix3d::Identity()) : Q;
  std::vector<Proposal> proposals;
  corrected_ = 0;
  for (Particle& particle : particles_) {
    const PlanarPose expected = (particle.path.empty() ? PlanarPose() : particle.path.back()) * motion;
    proposals.push_back(Propose(particle, expected, drawn, patch));
    corrected_ += proposals.back().loop.has_value();
    Move(particle, proposals.back());
  }
  const StepRange known = MappedSteps();
  motions_.push_back({step - 1, step, motion, Q});
  patches_.push_back(std::move(patch));
  if (options_.weighting == FloorWeighting::kLikelihood) {
    Reweigh(proposals);
  } else {
    ReweighByDifferences(known);
  }
  Resample();
  Search();
}

const FloorFilter::Submap* FloorFilter::DetachedSubmap() const {
  const auto last = std::find_if(submaps_.rbegin(), submaps_.rend(), [](const Submap& s) { return s.detached; });
  return last == submaps_.rend() ? nullptr : &*last;
}

int FloorFilter::detached_submaps() const {
  return int(std::count_if(submaps_.begin(), submaps_.end(), [](const Submap& s) { return s.detached; }));
}

/// Loop closures between the steps from `begin` on and the map of the steps before `map_end`, the best of each pose
/// found by searching for the former in the latter; best first.
std::vector<FloorLoop> FloorFilter::VerifiedLoops(int begin, int map_end) const {
  constexpr int kFinds = 6, kKeyframes = 8;
  const Particle& best = Best();
  const auto draw = [&](int first, int end) {
    return DrawFloor({patches_.begin() + first, patches_.begin() + end},
                     {best.path.begin() + first, best.path.begin() + end}, options_.search_cell_m);
  };
  const int steps = int(patches_.size());
  const Eigen::Matrix3d covariance = Covariance();
  FloorSearchRange range;
  range.reach_m = 3 * std::sqrt(covariance.topLeftCorner<2, 2>().trace()) + 2 * options_.search_cell_m;
  range.reach_rad = 3 * std::sqrt(covariance(2, 2)) + range.step_rad;
  std::vector<FloorLoop> verified;
  for (const FloorFind& find :
       SearchFloor(draw(0, map_end), draw(begin, steps), range, options_.search_cells, kFinds)) {
    std::optional<FloorLoop> loop;
    for (int k = steps - 1; k >= std::max(begin, steps - kKeyframes); --k) {
      const std::optional<FloorLoop> here = Verify(find.X_MS * best.path[size_t(k)], k, map_end);
      if (here && (!loop || here->correlation > loop->correlation)) loop = here;
    }
    if (loop) verified.push_back(*loop);
  }
  std::stable_sort(verified.begin(), verified.end(),
                   [](const FloorLoop& a, const FloorLoop& b) { return a.correlation > b.correlation; });
  return verified;
}

/// The loop closure of a keyframe with the map of the steps before `map_end`, if their images agree about `expected`.
std::optional<FloorLoop> FloorFilter::Verify(const PlanarPose& expected, int keyframe, int map_end) const {
  const FloorPatch& patch = patches_[size_t(keyframe)];
  if (patch.empty()) return std::nullopt;
  const std::vector<KnownFloor> known = FindKnown(Best(), expected, patch, {0, map_end});
  if (known.empty()) return std::nullopt;
  const std::optional<FloorMatch> match = MatchFloor(known, patch, expected, options_.match);
  if (!match || match->points < 2 * options_.match.min_points || !Agrees(*match)) return std::nullopt;
  return LoopOf(keyframe, known.front(), expected, *match);
}

/// Searches for the detached submap in the map. Without one, drift may exceed the reach of the particles' own matching:
/// then for the last keyframes.
void FloorFilter::Search() {
  constexpr int kKeyframes = 6;
  const Submap* submap = DetachedSubmap();
  const int steps = int(patches_.size());
  if (patches_.back().empty()) return;
  if (submap) {
    const int first = submap->first_step;
    if (const std::optional<FloorLoop> loop = UnambiguousLoop(first, first)) MoveOnto(first, *loop);
    return;
  }
  if (options_.weighting != FloorWeighting::kLikelihood) return;
  const StepRange known = MappedSteps();
  const double sigma_m = std::sqrt(Covariance().topLeftCorner<2, 2>().trace());
  if (sigma_m < options_.search_sigma_m || 2 * corrected_ > int(particles_.size()) ||
      FindKnown(Best(), Best().path.back(), patches_.back(), known).empty()) {
    return;
  }
  const std::optional<FloorLoop> loop = UnambiguousLoop(std::max(known.end, steps - kKeyframes), known.end);
  if (loop) MoveOnto(steps - 1, *loop);
}

/// The best verified loop closure, unless one that moves the trajectory elsewhere is about as good.
std::optional<FloorLoop> FloorFilter::UnambiguousLoop(int begin, int map_end) const {
  constexpr double kSamePosition_m = 0.1, kClearlyBetter = 0.03;
  const std::vector<FloorLoop> loops = VerifiedLoops(begin, map_end);
  if (loops.empty()) return std::nullopt;
  const std::vector<PlanarPose>& path = Best().path;
  const auto there = [&](const FloorLoop& loop) {  // where it moves the first pose to
    const PlanarPose move = path[size_t(loop.earlier)] * loop.motion * path[size_t(loop.keyframe)].Inverse();
    return move * path[size_t(begin)].position;
  };
  for (const FloorLoop& other : loops) {
    const bool elsewhere = (there(other) - there(loops.front())).norm() > kSamePosition_m;
    if (elsewhere && other.correlation > loops.front().correlation - kClearlyBetter) return std::nullopt;
  }
  return loops.front();
}

/// Moves the trajectory from step `begin` on to where a loop closure of it says. Submaps between are attached by it.
void FloorFilter::MoveOnto(int begin, const FloorLoop& loop) {
  for (Particle& particle : particles_) {
    std::vector<PlanarPose>& path = particle.path;
    const PlanarPose move = path[size_t(loop.earlier)] * loop.motion * path[size_t(loop.keyframe)].Inverse();
    for (size_t step = size_t(begin); step < path.size(); ++step) path[step] = move * path[step];
    particle.loops.push_back(loop);
  }
  for (Submap& submap : submaps_) submap.detached = submap.detached && submap.first_step <= loop.earlier;
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
  for (const Submap& submap : submaps_) {
    if (!submap.detached) continue;
    const PlanarPose& begin = Best().path[size_t(submap.first_step)];
    const Eigen::Vector2d arm = mean.position - begin.position;
    Eigen::Matrix3d J = Eigen::Matrix3d::Identity();  // of the last pose in W by the submap's first in its own frame
    J.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(begin.heading).toRotationMatrix();
    J.topRightCorner<2, 1>() = Eigen::Vector2d(-arm.y(), arm.x());
    covariance += J * submap.covariance * J.transpose();
  }
  return covariance;
}

/// All tracked motions and the best particle's loop closures.
std::vector<PlanarEdge> FloorFilter::Edges() const {
  std::vector<PlanarEdge> edges(motions_.begin() + 1, motions_.end());
  for (const FloorLoop& loop : BestLoops()) {
    edges.push_back({loop.earlier, loop.keyframe, loop.motion, loop.covariance, true});
  }
  return edges;
}

std::vector<PlanarPose> FloorFilter::SmoothPath() const {
  const std::vector<PlanarPose> start = BestPath();
  const bool graph = start.size() >= 2 && options_.weighting == FloorWeighting::kLikelihood;
  return graph ? SolvePlanarGraph(start, Edges()) : start;
}

std::vector<Eigen::Matrix3d> FloorFilter::SmoothCovariances(const std::vector<PlanarPose>& smooth) const {
  return smooth.size() < 2 ? std::vector<Eigen::Matrix3d>(smooth.size(), Eigen::Matrix3d::Zero())
                           : PlanarGraphCovariances(smooth, Edges());
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
