/// The floor that people walk on: how far anything is from walls and furniture, and ways around these.

#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace gaitcam {

using FloorPolygon = std::vector<Eigen::Vector2d>;  ///< Corners of a convex area, in either sense, m.

/// How far `p` is from the edge of a convex area, m; negative within it.
double SignedDistance(const FloorPolygon& polygon, const Eigen::Vector2d& p);

/// A grid over a rectangle of floor. Beyond its edge nobody walks.
class FloorMap {
 public:
  static constexpr double kFar_m = 1.5;        ///< Greater clearances are as good as this.
  static constexpr double kPassable_m = 0.37;  ///< Ways keep so far from everything.

  FloorMap(const Eigen::Vector2d& min, const Eigen::Vector2d& max, const std::vector<FloorPolygon>& obstacles);

  /// Somebody stands there from now on, with `radius_m` around the middle. Call before FindWays.
  void AddDisc(const Eigen::Vector2d& center, double radius_m);

  /// To the nearest obstacle or the floor's edge, interpolated, m; negative within them, at most kFar_m.
  double Clearance(const Eigen::Vector2d& p) const;
  /// Unit vector along which the clearance grows fastest; zero where it is even.
  Eigen::Vector2d Away(const Eigen::Vector2d& p) const;
  /// Whether the straight line between two points keeps `clearance_m` from everything.
  bool Sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double clearance_m) const;

  /// Finds which floor is joined: the largest such part is where people walk.
  void FindWays();
  /// Whether a place lies in that part. @pre FindWays was called.
  bool Reachable(const Eigen::Vector2d& p) const;

  /// Lengths of the ways from everywhere to one goal, by node; infinite where none leads. What is near to obstacles
  /// counts up to double.
  using Ways = std::vector<float>;
  Ways WaysTo(const Eigen::Vector2d& goal) const;
  /// The farthest point of the way from `p` that can be walked to straight on, up to 3 m ahead. @param clear tells
  /// whether a straight line is free of what the map does not know.
  template <class Clear>
  Eigen::Vector2d Ahead(const Ways& ways, const Eigen::Vector2d& p, const Eigen::Vector2d& goal,
                        const Clear& clear) const {
    constexpr double kLookAhead_m = 3;
    const auto goes = [&](const Eigen::Vector2d& to) { return Sees(p, to, kWalked_m) && clear(to); };
    if ((goal - p).norm() < kLookAhead_m && goes(goal)) return goal;
    int node = NearestPassable(p);
    if (node < 0) return goal;
    Eigen::Vector2d best = Place(node);
    while ((Place(node) - p).norm() < kLookAhead_m) {
      const int next = Downhill(ways, node);
      if (next == node) break;
      node = next;
      if (goes(Place(node))) best = Place(node);
    }
    return best;
  }

 private:
  static constexpr double kWalked_m = 0.34;  ///< Straight lines may come a little nearer than ways do.

  int Node(int x, int y) const { return y * width_ + x; }
  Eigen::Vector2d Place(int node) const {
    return min_ + spacing_m_ * Eigen::Vector2d(node % width_, node / width_);  // NOLINT: whole numbers are meant
  }
  bool Passable(int node) const { return clearance_[size_t(node)] >= kPassable_m; }
  int NearestPassable(const Eigen::Vector2d& p) const;
  int Downhill(const Ways& ways, int node) const;
  template <class Visit>
  void ForNeighbours(int node, const Visit& visit) const;
  template <class Distance>
  void Lower(const Eigen::Vector2d& min, const Eigen::Vector2d& max, const Distance& distance);

  Eigen::Vector2d min_;
  double spacing_m_ = 0.1;
  int width_ = 0, height_ = 0;
  std::vector<float> clearance_;
  std::vector<int> part_;  ///< Of joined floor, by node; -1 where nobody passes.
  int main_part_ = -1;
};

}  // namespace gaitcam
