/// A pose graph as g2o reads it (github.com/RainerKuemmerle/g2o, types slam3d): a line per node, then one per link.
///
///   VERTEX_SE3:QUAT id x y z qx qy qz qw
///   EDGE_SE3:QUAT from to x y z qx qy qz qw  and 21 numbers: the information, upper triangle row by row
///
/// g2o's error is the translation and the vector part of the quaternion, half the rotation vector of se3.h to first
/// order: information of rotations is multiplied by 2 for each index of a rotation. Links that were found false are
/// comments. Numbers read back to the same bits.

#pragma once

#include <filesystem>

#include "algorithms/core/pose_graph.h"

namespace gaitcam {

/// @throws MissingResource if it cannot be written.
void WritePoseGraph(const std::filesystem::path& file, const PoseGraph& graph);

}  // namespace gaitcam
