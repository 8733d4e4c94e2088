#include "algorithms/io/pose_graph_file.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <string>

#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

std::string PoseText(const Pose& X) {
  const auto& t = X.translation;
  const auto& q = X.rotation;
  return fmt::format("{} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::string InformationText(const Matrix6d& covariance) {
  const Matrix6d information = covariance.llt().solve(Matrix6d::Identity());
  std::string text;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      const int halves = int(row >= 3) + int(column >= 3);
      text += fmt::format(" {}", information(row, column) * (1 << halves));
    }
  }
  return text;
}

}  // namespace

void WritePoseGraph(const std::filesystem::path& file, const PoseGraph& graph) {
  std::string text;
  for (size_t n = 0; n < graph.nodes.size(); ++n)
    text += fmt::format("VERTEX_SE3:QUAT {} {}\n", n, PoseText(graph.nodes[n].X_WC));
  for (const GraphLink& link : graph.links) {
    text += fmt::format("{}EDGE_SE3:QUAT {} {} {}{}\n", link.trust < 0.5 ? "# false: " : "", link.from, link.to,
                        PoseText(link.X_FT), InformationText(link.covariance));
  }
  WriteWholeFile(file, text);
}

}  // namespace gaitcam
