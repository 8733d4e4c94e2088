/// Paths and maps seen from above, as an SVG figure of a page in metres.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace gaitcam::internal {

/// The ground that everything drawn lies on: x to the right, y up.
class GroundDrawing {
 public:
  /// @param points all that must fit into the figure, m, in the world's frame
  explicit GroundDrawing(const std::vector<Eigen::Vector2d>& points);

  double x(const Eigen::Vector2d& p) const { return p.x() - low_.x(); }  ///< Of the figure, m.
  double y(const Eigen::Vector2d& p) const { return high_.y() - p.y(); }
  double unit() const { return unit_; }  ///< A hundredth of the larger side, m.

  /// @param kind class of the element in page.css
  std::string Path(const std::vector<Eigen::Vector2d>& points, const char* kind = "path") const;
  std::string Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const char* kind) const;
  std::string Circle(const Eigen::Vector2d& p, double radius_m, const std::string& kind) const;
  /// The figure with this content.
  std::string Svg(const std::string& content, const char* label) const;

 private:
  Eigen::Vector2d low_, high_;
  double unit_;
};

}  // namespace gaitcam::internal
