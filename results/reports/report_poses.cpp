#include "results/reports/report_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "algorithms/core/units.h"
#include "results/reports/covariance_ellipse.h"
#include "results/reports/ground_drawing.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/scoring/score_text.h"

namespace gaitcam {
using Eigen::Vector2d;

ReportSection PoseGraphReportSection(const PoseGraphComparison& comparison, const PoseGraph& graph,
                                     const Trajectory& truth, const Similarity& X_WV) {
  std::vector<Vector2d> path, nodes, all;
  for (const StampedPose& pose : truth) path.push_back(pose.pose.translation.head<2>());
  for (const GraphNode& node : graph.nodes) nodes.push_back((X_WV * node.X_WC.translation).head<2>());
  all = path;
  all.insert(all.end(), nodes.begin(), nodes.end());
  const internal::GroundDrawing ground(all);
  std::vector<internal::PositionEllipse> ellipses;
  for (const GraphNode& node : graph.nodes) {
    ellipses.push_back(internal::EllipseOf(X_WV.rotation * node.X_WC.rotation, node.covariance));
  }
  const double magnification = internal::EllipseMagnification(ellipses, ground.unit());

  std::string content = ground.Path(path);
  for (size_t n = 0; n < nodes.size(); ++n) {
    const Vector2d axes = (magnification * ellipses[n].axes_m).cwiseMax(0.2 * ground.unit());
    content += fmt::format(
        "<ellipse class=\"covariance\" rx=\"{:.4f}\" ry=\"{:.4f}\" transform=\"translate({:.3f} {:.3f}) "
        "rotate({:.1f})\"><title>node {}: 95 % ellipse {:.1f} x {:.1f} mm</title></ellipse>",
        axes.x(), axes.y(), ground.x(nodes[n]), ground.y(nodes[n]), -kDegPerRad * ellipses[n].turn_rad, n,
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
