#include "models/code/people/floor_map.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kMostNodes = 90000;
constexpr double kFinest_m = 0.1, kCoarsest_m = 0.25;
constexpr double kComfort_m = 0.8;  // ways prefer to stay so far from everything

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

double SignedDistance(const FloorPolygon& polygon, const Vector2d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  bool left = false, right = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], along = polygon[(i + 1) % polygon.size()] - a;
    const double part = along.squaredNorm() > 0 ? (p - a).dot(along) / along.squaredNorm() : 0;
    nearest = std::min(nearest, (a + std::clamp(part, 0.0, 1.0) * along - p).norm());
    const double side = Cross(along, p - a);
    left = left || side > 0;
    right = right || side < 0;
  }
  return left && right ? nearest : -nearest;
}

FloorMap::FloorMap(const Vector2d& min, const Vector2d& max, const std::vector<FloorPolygon>& obstacles) : min_(min) {
  const Vector2d size = max - min;
  GAITCAM_ASSERT(size.minCoeff() > 0);
  spacing_m_ = std::clamp(std::sqrt(size.prod() / kMostNodes), kFinest_m, kCoarsest_m);
  width_ = int(size.x() / spacing_m_) + 1;
  height_ = int(size.y() / spacing_m_) + 1;
  clearance_.assign(size_t(width_) * size_t(height_), float(kFar_m));
  Lower(min, max, [&](const Vector2d& p) { return std::min((p - min).minCoeff(), (max - p).minCoeff()); });
  for (const FloorPolygon& polygon : obstacles) {
    Vector2d low = polygon[0], high = low;
    for (const Vector2d& corner : polygon) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    Lower(low, high, [&](const Vector2d& p) { return SignedDistance(polygon, p); });
  }
}

void FloorMap::AddDisc(const Vector2d& center, double radius_m) {
  const Vector2d reach(radius_m, radius_m);
  Lower(center - reach, center + reach, [&](const Vector2d& p) { return (p - center).norm() - radius_m; });
}

/// Lowers the clearance of the nodes that are nearer than kFar_m to a rectangle.
template <class Distance>
void FloorMap::Lower(const Vector2d& min, const Vector2d& max, const Distance& distance) {
  const auto index = [this](double way, int count) { return std::clamp(int(way / spacing_m_), 0, count - 1); };
  const Vector2d low = min - min_ - Vector2d(kFar_m, kFar_m), high = max - min_ + Vector2d(kFar_m, kFar_m);
  for (int y = index(low.y(), height_); y <= index(high.y() + spacing_m_, height_); ++y) {
    for (int x = index(low.x(), width_); x <= index(high.x() + spacing_m_, width_); ++x) {
      float& clearance = clearance_[size_t(Node(x, y))];
      clearance = std::min(clearance, float(distance(Place(Node(x, y)))));
    }
  }
}

double FloorMap::Clearance(const Vector2d& p) const {
  const Vector2d at = (p - min_) / spacing_m_;
  const double x = std::clamp(at.x(), 0.0, double(width_ - 1)), y = std::clamp(at.y(), 0.0, double(height_ - 1));
  const int left = std::min(int(x), width_ - 2), low = std::min(int(y), height_ - 2);
  const double u = x - left, v = y - low;
  const auto node = [&](int i, int j) { return double(clearance_[size_t(Node(left + i, low + j))]); };
  const double inside = (1 - v) * ((1 - u) * node(0, 0) + u * node(1, 0)) + v * ((1 - u) * node(0, 1) + u * node(1, 1));
  return inside - spacing_m_ * (at - Vector2d(x, y)).norm();
}

Vector2d FloorMap::Away(const Vector2d& p) const {
  const double h = spacing_m_ / 2;
  const Vector2d slope(Clearance(p + Vector2d(h, 0)) - Clearance(p - Vector2d(h, 0)),
                       Clearance(p + Vector2d(0, h)) - Clearance(p - Vector2d(0, h)));
  return slope.norm() > 1e-9 ? Vector2d(slope.normalized()) : Vector2d(0, 0);
}

bool FloorMap::Sees(const Vector2d& from, const Vector2d& to, double clearance_m) const {
  const double length = (to - from).norm();
  for (double way = 0; way < length;) {
    // Nothing is nearer than the clearance, so that much can be left out.
    const double clearance = Clearance(from + way / length * (to - from));
    if (clearance < clearance_m) return false;
    way += std::max(clearance - clearance_m, spacing_m_ / 2);
  }
  return Clearance(to) >= clearance_m;
}

template <class Visit>
void FloorMap::ForNeighbours(int node, const Visit& visit) const {
  const int x = node % width_, y = node / width_;
  for (int j = std::max(0, y - 1); j <= std::min(height_ - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(width_ - 1, x + 1); ++i) {
      const int next = Node(i, j);
      if (next != node && Passable(next)) visit(next, i != x && j != y ? std::sqrt(2.0) * spacing_m_ : spacing_m_);
    }
  }
}

void FloorMap::FindWays() {
  part_.assign(clearance_.size(), -1);
  size_t largest = 0;
  int parts = 0;
  for (int seed = 0; seed < int(part_.size()); ++seed) {
    if (!Passable(seed) || part_[size_t(seed)] >= 0) continue;
    std::vector<int> found{seed};
    part_[size_t(seed)] = parts;
    for (size_t i = 0; i < found.size(); ++i) {
      ForNeighbours(found[i], [&](int next, double) {
        if (part_[size_t(next)] >= 0) return;
        part_[size_t(next)] = parts;
        found.push_back(next);
      });
    }
    if (found.size() > largest) {
      largest = found.size();
      main_part_ = parts;
    }
    ++parts;
  }
}

bool FloorMap::Reachable(const Vector2d& p) const {
  if (Clearance(p) < kPassable_m) return false;
  const int node = NearestPassable(p);
  return node >= 0 && part_[size_t(node)] == main_part_;
}

/// Within two nodes of `p`; -1 if there is none.
int FloorMap::NearestPassable(const Vector2d& p) const {
  constexpr int kReach = 2;
  const Vector2d at = (p - min_) / spacing_m_;
  const int x = int(std::lround(at.x())), y = int(std::lround(at.y()));
  int best = -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (int j = std::max(0, y - kReach); j <= std::min(height_ - 1, y + kReach); ++j) {
    for (int i = std::max(0, x - kReach); i <= std::min(width_ - 1, x + kReach); ++i) {
      const double distance = (Place(Node(i, j)) - p).norm();
      if (!Passable(Node(i, j)) || distance >= nearest) continue;
      nearest = distance;
      best = Node(i, j);
    }
  }
  return best;
}

/// Dijkstra's algorithm on a grid with eight neighbours.
FloorMap::Ways FloorMap::WaysTo(const Vector2d& goal) const {
  Ways ways(clearance_.size(), std::numeric_limits<float>::infinity());
  const int first = NearestPassable(goal);
  if (first < 0) return ways;
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  ways[size_t(first)] = 0;
  open.emplace(0.0f, first);
  while (!open.empty()) {
    const auto [way, node] = open.top();
    open.pop();
    if (way > ways[size_t(node)]) continue;
    ForNeighbours(node, [&, way = way](int next, double step) {
      const double narrow = std::clamp((kComfort_m - clearance_[size_t(next)]) / (kComfort_m - kPassable_m), 0.0, 1.0);
      const float longer = way + float(step * (1 + narrow));
      if (longer >= ways[size_t(next)]) return;
      ways[size_t(next)] = longer;
      open.emplace(longer, next);
    });
  }
  return ways;
}

int FloorMap::Downhill(const Ways& ways, int node) const {
  int best = node;
  ForNeighbours(node, [&](int next, double) {
    if (ways[size_t(next)] < ways[size_t(best)]) best = next;
  });
  return best;
}

}  // namespace gaitcam
