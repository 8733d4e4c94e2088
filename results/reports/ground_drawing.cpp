#include "results/reports/ground_drawing.h"

#include <fmt/format.h>

#include <algorithm>

namespace gaitcam::internal {

using Eigen::Vector2d;

GroundDrawing::GroundDrawing(const std::vector<Vector2d>& points) {
  low_ = Vector2d::Constant(1e9);
  high_ = -low_;
  for (const Vector2d& p : points) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  unit_ = std::max(0.5, (high_ - low_).maxCoeff()) / 100;
  low_ -= Vector2d::Constant(5 * unit_);
  high_ += Vector2d::Constant(5 * unit_);
}

std::string GroundDrawing::Path(const std::vector<Vector2d>& points, const char* kind) const {
  std::string list;
  for (const Vector2d& p : points) list += fmt::format("{:.3f},{:.3f} ", x(p), y(p));
  return fmt::format("<polyline class=\"{}\" points=\"{}\"/>", kind, list);
}

std::string GroundDrawing::Line(const Vector2d& a, const Vector2d& b, const char* kind) const {
  return fmt::format("<line class=\"{}\" x1=\"{:.3f}\" y1=\"{:.3f}\" x2=\"{:.3f}\" y2=\"{:.3f}\"/>", kind, x(a), y(a),
                     x(b), y(b));
}

std::string GroundDrawing::Circle(const Vector2d& p, double radius_m, const std::string& kind) const {
  return fmt::format("<circle class=\"{}\" cx=\"{:.3f}\" cy=\"{:.3f}\" r=\"{:.3f}\"/>", kind, x(p), y(p), radius_m);
}

std::string GroundDrawing::Svg(const std::string& content, const char* label) const {
  return fmt::format(
      "<div class=\"panel graph\"><svg viewBox=\"0 0 {:.3f} {:.3f}\" role=\"img\" aria-label=\"{}\">{}"
      "</svg></div>\n",
      high_.x() - low_.x(), high_.y() - low_.y(), label, content);
}

}  // namespace gaitcam::internal
