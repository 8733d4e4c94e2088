#include "sim/camera/cover.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gaitcam {
namespace {

constexpr int kCellsAcross = 480;  // the picture

/// Columns that a convex polygon has in common with a horizontal line; first > second: none.
std::pair<double, double> Crossing(std::span<const Eigen::Vector3d> polygon, double row) {
  std::pair<double, double> span{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > row) == (b.y() > row)) continue;
    const double column = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    span = {std::min(span.first, column), std::max(span.second, column)};
  }
  return span;
}

}  // namespace

Cover::Cover(const Pose& X_WC, const CameraModel& camera, double near_m) : X_CW_(X_WC.Inverse()), near_(near_m) {
  const double cell_px = double(camera.width_px) / kCellsAcross;
  fx_ = camera.fx / cell_px;
  fy_ = camera.fy / cell_px;
  // A cell more on each side, for sub-pixel offsets.
  cx_ = (camera.cx + 0.5) / cell_px + 1;
  cy_ = (camera.cy + 0.5) / cell_px + 1;
  columns_ = int(std::ceil(camera.width_px / cell_px)) + 2;
  rows_ = int(std::ceil(camera.height_px / cell_px)) + 2;
  nearness_.assign(size_t(columns_) * size_t(rows_), 0.f);
}

Eigen::Vector3d Cover::Project(const Eigen::Vector3d& p_C) const {
  const double nearness = 1 / p_C.z();
  return {fx_ * p_C.x() * nearness + cx_, fy_ * p_C.y() * nearness + cy_, nearness};
}

void Cover::Add(const std::array<Disc, 2>& ends) {
  std::array<Disc, 2> seen;
  for (size_t i = 0; i < 2; ++i) {
    seen[i] = {X_CW_ * ends[i].center, X_CW_.R() * ends[i].a, X_CW_.R() * ends[i].b};
    const Disc& disc = seen[i];
    if (disc.center.z() - std::hypot(disc.a.z(), disc.b.z()) <= near_) return;
  }
  AddSide(seen);
  AddDisc(seen[0]);
  AddDisc(seen[1]);
}

/// The cut through the axis that faces the camera.
void Cover::AddSide(const std::array<Disc, 2>& ends) {
  const Eigen::Vector3d &from = ends[0].center, &to = ends[1].center;
  const Eigen::Vector3d across = (to - from).cross(from + to);
  const auto rim = [&](const Disc& disc) -> Eigen::Vector3d {
    const Eigen::Vector2d part(across.dot(disc.a) / disc.a.squaredNorm(), across.dot(disc.b) / disc.b.squaredNorm());
    const Eigen::Vector2d unit = part.stableNormalized();
    return unit.x() * disc.a + unit.y() * disc.b;
  };
  const Eigen::Vector3d at_from = rim(ends[0]), at_to = rim(ends[1]);
  AddPolygon(std::array{Project(from - at_from), Project(from + at_from), Project(to + at_to), Project(to - at_to)});
}

void Cover::AddDisc(const Disc& disc) {
  std::array<Eigen::Vector3d, 8> corners;
  for (size_t i = 0; i < corners.size(); ++i) {
    const double angle = 2 * M_PI * double(i) / double(corners.size());
    corners[i] = Project(disc.center + std::cos(angle) * disc.a + std::sin(angle) * disc.b);
  }
  AddPolygon(corners);
}

/// Over a plane, 1/z is linear in the picture.
void Cover::AddPolygon(std::span<const Eigen::Vector3d> polygon) {
  const Eigen::Vector3d u = polygon[1] - polygon[0], v = polygon.back() - polygon[0];
  const double area = u.x() * v.y() - u.y() * v.x();
  if (!(std::abs(area) > 0.5)) return;  // of half a cell
  const double by_column = (u.z() * v.y() - u.y() * v.z()) / area, by_row = (u.x() * v.z() - u.z() * v.x()) / area;
  double top = polygon[0].y(), bottom = top;
  for (const Eigen::Vector3d& corner : polygon) {
    top = std::min(top, corner.y());
    bottom = std::max(bottom, corner.y());
  }
  const int first_row = std::max(0, int(std::ceil(top))), end_row = std::min(rows_, int(std::floor(bottom)));
  std::pair<double, double> upper = Crossing(polygon, first_row);
  for (int row = first_row; row < end_row; ++row) {
    const std::pair<double, double> lower = Crossing(polygon, row + 1);
    const double left = std::max({0.0, upper.first, lower.first});
    const double right = std::min({double(columns_), upper.second, lower.second});
    upper = lower;
    if (!(left < right)) continue;
    // The farthest corner of each cell.
    const double offset = polygon[0].z() - by_column * polygon[0].x() - by_row * polygon[0].y() +
                          std::min(by_column, 0.0) + by_row * (row + (by_row < 0 ? 1 : 0));
    float* cells = nearness_.data() + ptrdiff_t{row} * columns_;
    const int end = int(std::floor(right));
    for (int column = int(std::ceil(left)); column < end; ++column) {
      cells[column] = std::max(cells[column], float(offset + by_column * column));
    }
  }
}

/// Slice by slice: in the picture, a long slanted box fills little of the rectangle around it.
bool Cover::HidesBox(const Pose& X_WB, const Eigen::Vector3d& low, const Eigen::Vector3d& high) const {
  constexpr int kSlices = 4;
  int longest = 0;
  (high - low).maxCoeff(&longest);
  const Pose X_CB = X_CW_ * X_WB;
  const auto section = [&](int slice) {
    std::array<Eigen::Vector3d, 4> corners;
    for (int i = 0; i < 4; ++i) {
      Eigen::Vector3d p;
      p[longest] = low[longest] + slice * (high[longest] - low[longest]) / kSlices;
      const int u = (longest + 1) % 3, v = (longest + 2) % 3;
      p[u] = i & 1 ? high[u] : low[u];
      p[v] = i & 2 ? high[v] : low[v];
      corners[size_t(i)] = X_CB * p;
    }
    return corners;
  };
  std::array<Eigen::Vector3d, 4> from = section(0);
  for (int slice = 0; slice < kSlices; ++slice) {
    const std::array<Eigen::Vector3d, 4> to = section(slice + 1);
    if (!Hides({from[0], from[1], from[2], from[3], to[0], to[1], to[2], to[3]})) return false;
    from = to;
  }
  return true;
}

bool Cover::Hides(const Corners& corners) const {
  Eigen::Array2d low(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()), high = -low;
  double nearest = 0;
  for (const Eigen::Vector3d& p_C : corners) {
    if (p_C.z() <= near_) return false;
    const Eigen::Vector3d seen = Project(p_C);
    low = low.min(seen.head<2>().array());
    high = high.max(seen.head<2>().array());
    nearest = std::max(nearest, seen.z());
  }
  const Eigen::Array2d size(columns_, rows_);
  const Eigen::Array2i first = low.max(0.0).min(size).cast<int>();
  const Eigen::Array2i last = high.max(-1.0).min(size - 1).floor().cast<int>();
  for (int row = first.y(); row <= last.y(); ++row) {
    const float* cells = nearness_.data() + ptrdiff_t{row} * columns_;
    for (int column = first.x(); column <= last.x(); ++column) {
      if (cells[column] <= nearest) return false;
    }
  }
  return true;
}

}  // namespace gaitcam
