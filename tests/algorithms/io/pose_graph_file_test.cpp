#include "algorithms/io/pose_graph_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

TEST(PoseGraphFile, IsWhatG2oReads) {
  PoseGraph graph;
  graph.nodes = {{0, Pose(), {}}, {1, Pose(Eigen::Quaterniond(0, 0, 0, 1), {1, 2, 3}), {}}};
  Vector6d variance;
  variance << 0.25, 0.25, 0.25, 0.0625, 0.0625, 0.0625;  // whose roots are exact
  graph.links.push_back({0, 1, graph.nodes[1].X_WC, variance.asDiagonal(), false, 1});
  graph.links.push_back({0, 1, Pose(), Matrix6d::Identity(), true, 0});
  const TemporaryFolder folder;
  WritePoseGraph(folder.path() / "graph.g2o", graph);
  std::ifstream in(folder.path() / "graph.g2o");
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1");
  std::getline(in, line);
  EXPECT_EQ(line, "VERTEX_SE3:QUAT 1 1 2 3 0 0 1 0");
  std::getline(in, line);
  // Half the rotation vector: four times the information of 1 / 0.0625.
  EXPECT_EQ(line,
            "EDGE_SE3:QUAT 0 1 1 2 3 0 0 1 0"
            " 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 64 0 0 64 0 64");
  std::getline(in, line);
  EXPECT_THAT(line, testing::StartsWith("# false: EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1"));
}

}  // namespace
}  // namespace gaitcam
