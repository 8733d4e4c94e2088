#include "results/reports/report_poses.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "algorithms/core/median.h"
#include "algorithms/core/units.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/scoring/score_text.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// Semi-axes of a 95 % ellipse, m, and its direction in the drawing.
struct Ellipse {
  Vector2d axes_m;
  double turn_deg = 0;
};

/// Of a node's position seen from above.
Ellipse EllipseOf(const GraphNode& node, const Similarity& X_WV) {
  const double k95 = std::sqrt(5.991);  // chi-square of two degrees of freedom
  const Eigen::Matrix3d R = (X_WV.rotation * node.X_WC.rotation).toRotationMatrix();
  const Eigen::Matrix3d covariance = R * node.covariance.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  const Vector2d major = axes.eigenvectors().col(1);
  return {k95 * axes.eigenvalues().cwiseMax(0).cwiseSqrt().reverse(),
          -kDegPerRad * std::atan2(major.y(), major.x())};  // the drawing's y points down
}

/// Positions on the ground, for a drawing whose y points down.
class Ground {
 public:
  explicit Ground(const std::vector<Vector2d>& points) {
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
  double x(const Vector2d& p) const { return p.x() - low_.x(); }
  double y(const Vector2d& p) const { return high_.y() - p.y(); }
  double unit() const { return unit_; }  ///< A hundredth of the larger side, m.
  std::string Svg(const std::string& content) const {
    return fmt::format(
        "<div class=\"panel graph\"><svg viewBox=\"0 0 {:.3f} {:.3f}\" role=\"img\" "
        "aria-label=\"pose graph\">{}</svg></div>\n",
        high_.x() - low_.x(), high_.y() - low_.y(), content);
  }

 private:
  Vector2d low_, high_;
  double unit_;
};

std::string LinkLine(const Ground& ground, const Vector2d& a, const Vector2d& b, const char* kind) {
  return fmt::format("<line class=\"{}\" x1=\"{:.3f}\" y1=\"{:.3f}\" x2=\"{:.3f}\" y2=\"{:.3f}\"/>", kind, ground.x(a),
                     ground.y(a), ground.x(b), ground.y(b));
}

/// Ellipses are so many times their true size that the median one can be seen.
double Magnification(const std::vector<Ellipse>& ellipses, double unit_m) {
  constexpr double kVisible = 1.5;  // in units of the drawing
  std::vector<double> majors;
  for (const Ellipse& ellipse : ellipses) majors.push_back(ellipse.axes_m.x());
  const double median_m = majors.empty() ? 0 : UpperMedian(std::move(majors));
  if (median_m <= 0) return 1;
  const double wanted = kVisible * unit_m / median_m;
  return wanted <= 1 ? 1 : std::pow(10, std::round(std::log10(wanted)));
}

}  // namespace

ReportSection PoseGraphReportSection(const PoseGraphComparison& comparison, const PoseGraph& graph,
                                     const Trajectory& truth, const Similarity& X_WV) {
  std::vector<Vector2d> path, nodes, all;
  for (const StampedPose& pose : truth) path.push_back(pose.pose.translation.head<2>());
  for (const GraphNode& node : graph.nodes) nodes.push_back((X_WV * node.X_WC.translation).head<2>());
  all = path;
  all.insert(all.end(), nodes.begin(), nodes.end());
  const Ground ground(all);
  std::vector<Ellipse> ellipses;
  for (const GraphNode& node : graph.nodes) ellipses.push_back(EllipseOf(node, X_WV));
  const double magnification = Magnification(ellipses, ground.unit());

  std::string content, points;
  for (const Vector2d& p : path) points += fmt::format("{:.3f},{:.3f} ", ground.x(p), ground.y(p));
  content += fmt::format("<polyline class=\"path\" points=\"{}\"/>", points);
  for (size_t n = 0; n < nodes.size(); ++n) {
    const Vector2d axes = (magnification * ellipses[n].axes_m).cwiseMax(0.2 * ground.unit());
    content += fmt::format(
        "<ellipse class=\"covariance\" rx=\"{:.4f}\" ry=\"{:.4f}\" transform=\"translate({:.3f} {:.3f}) "
        "rotate({:.1f})\"><title>node {}: 95 % ellipse {:.1f} x {:.1f} mm</title></ellipse>",
        axes.x(), axes.y(), ground.x(nodes[n]), ground.y(nodes[n]), ellipses[n].turn_deg, n,
        1e3 * ellipses[n].axes_m.x(), 1e3 * ellipses[n].axes_m.y());
  }
  for (const GraphLink& link : graph.links) {
    if (!link.loop) content += LinkLine(ground, nodes[size_t(link.from)], nodes[size_t(link.to)], "link");
  }
  for (const JudgedLoop& loop : comparison.loops) {
    const GraphLink& link = graph.links[size_t(loop.link)];
    const char* kind = !loop.kept ? "refused" : loop.right ? "right" : "wrong";
    content += LinkLine(ground, nodes[size_t(link.from)], nodes[size_t(link.to)], kind);
  }
  ReportSection section;
  section.body = "<h2>Pose graph</h2>\n" +
                 internal::Key({{"truth", "true path"},
                                {"sim3", "links by odometry"},
                                {"green", "loop closures"},
                                {"bad", "false ones that are trusted", "dashed"},
                                {"se3", "links found false", "dashed"}},
                               "") +
                 ground.Svg(content) +
                 fmt::format(
                     "<p>Ellipses: 95 % of each pose's position, drawn {:.0f} times as large; the first pose is "
                     "the world.</p>\n",
                     magnification);
  for (const Score& score : comparison.scores) {
    if (score.name == "graph_loops")
      section.cards += internal::Card("Loops closed", score.value, "", fmt::format("of {} poses", graph.nodes.size()));
  }
  section.style = std::string(internal::PageFile("report_graph.css"));
  return section;
}

}  // namespace gaitcam
