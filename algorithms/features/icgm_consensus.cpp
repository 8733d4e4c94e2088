#include "algorithms/features/icgm_consensus.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kShare = 0.5;  // of the others with whom each agrees
constexpr int kPasses = 2;
constexpr int kLeastNeighbours = 3;
constexpr double kSamePoint_px = 2;  // one point matched twice is no evidence for itself

bool AgreeWithin(const Vector2d& u, const Vector2d& v, double threshold, double noise_px) {
  return (u - v).norm() <= threshold * (u.norm() + v.norm()) + noise_px;
}

/// The nearest matches of a set in the first image, nearest first.
std::vector<int> NearestOf(int i, const std::vector<MatchedPosition>& matches, const std::vector<char>& in, int count) {
  std::vector<std::pair<double, int>> nearest;
  const MatchedPosition& own = matches[size_t(i)];
  double limit = std::numeric_limits<double>::infinity();
  for (int j = 0; j < int(matches.size()); ++j) {
    if (in[size_t(j)] == 0 || j == i) continue;
    const MatchedPosition& other = matches[size_t(j)];
    const double distance2 = (other.a - own.a).squaredNorm();
    if (distance2 >= limit || distance2 < kSamePoint_px * kSamePoint_px ||
        (other.b - own.b).squaredNorm() < kSamePoint_px * kSamePoint_px)
      continue;
    const std::pair<double, int> candidate{distance2, j};
    nearest.insert(std::upper_bound(nearest.begin(), nearest.end(), candidate), candidate);
    if (int(nearest.size()) > count) nearest.pop_back();
    if (int(nearest.size()) == count) limit = nearest.back().first;
  }
  std::vector<int> indices;
  for (const auto& [distance2, j] : nearest) indices.push_back(j);
  return indices;
}

/// Whether a match moved as its neighbours did. Two of them differ by the noise of both.
bool AgreesNearby(const MatchedPosition& own, const std::vector<MatchedPosition>& matches,
                  const std::vector<int>& neighbours, const IcgmOptions& options) {
  if (int(neighbours.size()) < kLeastNeighbours) return false;
  int count = 0;
  MatchedPosition centre;
  for (const int j : neighbours) {
    const MatchedPosition& other = matches[size_t(j)];
    if (!AgreeWithin(other.a - own.a, other.b - own.b, options.near_threshold, std::sqrt(2.0) * options.noise_px))
      continue;
    ++count;
    centre.a += (other.a - centre.a) / count;
    centre.b += (other.b - centre.b) / count;
  }
  return count > 0 && count * options.neighbours >= options.agreeing * int(neighbours.size()) &&
         AgreeWithin(centre.a - own.a, centre.b - own.b, options.centre_threshold, options.noise_px);
}

}  // namespace

Agreement::Agreement(const std::vector<MatchedPosition>& matches, double threshold, double noise_px) {
  const auto n = Eigen::Index(matches.size());
  Eigen::ArrayXf ax(n), ay(n), bx(n), by(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    ax[i] = float(matches[size_t(i)].a.x());
    ay[i] = float(matches[size_t(i)].a.y());
    bx[i] = float(matches[size_t(i)].b.x());
    by[i] = float(matches[size_t(i)].b.y());
  }
  agrees_.resize(n, n);
  Eigen::ArrayXf ux(n), uy(n), vx(n), vy(n), allowed(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    ux = ax - ax[i];
    uy = ay - ay[i];
    vx = bx - bx[i];
    vy = by - by[i];
    allowed =
        float(threshold) * ((ux.square() + uy.square()).sqrt() + (vx.square() + vy.square()).sqrt()) + float(noise_px);
    agrees_.row(i) = ((ux - vx).square() + (uy - vy).square() <= allowed.square()).cast<unsigned char>();
    agrees_(i, i) = 0;
  }
}

int Agreement::Count(int i, const std::vector<char>& in) const {
  int count = 0;
  for (size_t j = 0; j < in.size(); ++j) count += agrees_(i, Eigen::Index(j)) & in[j];
  return count;
}

std::vector<char> Agreement::Core() const {
  const int n = int(agrees_.rows());
  std::vector<char> in(size_t(n), 1);
  std::vector<int> degree(size_t(n), 0);
  for (int i = 0; i < n; ++i) degree[size_t(i)] = Count(i, in);
  for (int left = n; left > 0; --left) {
    int fewest = -1;
    for (int i = 0; i < n; ++i)
      if (in[size_t(i)] != 0 && (fewest < 0 || degree[size_t(i)] < degree[size_t(fewest)])) fewest = i;
    if (degree[size_t(fewest)] >= kShare * (left - 1)) break;
    in[size_t(fewest)] = 0;
    for (int j = 0; j < n; ++j) degree[size_t(j)] -= agrees_(fewest, j);
  }
  return in;
}

std::vector<int> KeepByConsensus(const std::vector<MatchedPosition>& matches, double threshold,
                                 const IcgmOptions& options) {
  const int n = int(matches.size());
  const Agreement agreement(matches, threshold, options.noise_px);
  std::vector<char> in = agreement.Core();
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto size = std::count(in.begin(), in.end(), 1);
    std::vector<char> kept(size_t(n), 0);
    for (int i = 0; i < n; ++i) {
      if (agreement.Count(i, in) < kShare * double(size - 1)) continue;
      kept[size_t(i)] =
          AgreesNearby(matches[size_t(i)], matches, NearestOf(i, matches, in, options.neighbours), options) ? 1 : 0;
    }
    in = std::move(kept);
  }
  std::vector<int> kept;
  for (int i = 0; i < n; ++i)
    if (in[size_t(i)] != 0) kept.push_back(i);
  return kept;
}

}  // namespace gaitcam
