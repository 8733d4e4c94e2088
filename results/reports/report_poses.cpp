#include "results/reports/report_poses.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "algorithms/core/median.h"
#include "algorithms/core/units.h"
#include "results/reports/ground_drawing.h"
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
  const internal::GroundDrawing ground(all);
  std::vector<Ellipse> ellipses;
  for (const GraphNode& node : graph.nodes) ellipses.push_back(EllipseOf(node, X_WV));
  const double magnification = Magnification(ellipses, ground.unit());

  std::string content = ground.Path(path);
  for (size_t n = 0; n < nodes.size(); ++n) {
    const Vector2d axes = (magnification * ellipses[n].axes_m).cwiseMax(0.2 * ground.unit());
    content += fmt::format(
        "<ellipse class=\"covariance\" rx=\"{:.4f}\" ry=\"{:.4f}\" transform=\"translate({:.3f} {:.3f}) "
        "rotate({:.1f})\"><title>node {}: 95 % ellipse {:.1f} x {:.1f} mm</title></ellipse>",
        axes.x(), axes.y(), ground.x(nodes[n]), ground.y(nodes[n]), ellipses[n].turn_deg, n,
        1e3 * ellipses[n].axes_m.x(), 1e3 * ellipses[n].axes_m.y());
  }
  for (const GraphLink& link : graph.links) {
    if (!link.loop) content += ground.Line(nodes[size_t(link.from)], nodes[size_t(link.to)], "link");
  }
  for (const JudgedLoop& loop : comparison.loops) {
    const GraphLink& link = graph.links[size_t(loop.link)];
    const char* kind = !loop.kept ? "refused" : loop.right ? "right" : "wrong";
    content += ground.Line(nodes[size_t(link.from)], nodes[size_t(link.to)], kind);
  }
  ReportSection section;
  section.body = "<h2>Pose graph</h2>\n" +
                 internal::Key({{"truth", "true path"},
                                {"sim3", "links by odometry"},
                                {"green", "loop closures"},
                                {"bad", "false ones that are trusted", "dashed"},
                                {"se3", "links found false", "dashed"}},
                               "") +
                 ground.Svg(content, "pose graph") +
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
