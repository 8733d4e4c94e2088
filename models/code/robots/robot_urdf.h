/// The part of a robot described by its URDF file: links, joints, shapes and inertias, read through urdfdom.

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "models/code/robots/robot.h"

namespace gaitcam {

/// Links and joints, root first and every parent before its children, siblings in the order of the file.
struct UrdfTree {
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;  ///< joints[i].child_link is i + 1.
  std::vector<double> efforts;     ///< Per joint: the limit's effort, N m or N; 0 where none is stated.
};

/// @param masses of links that have no `<inertial>`, kg; the inertia is that of their shapes, filled uniformly.
/// @throws BadInput "file:line: element: what is wrong and what is expected": XML that does not parse, names given
/// twice or unknown, no or two roots, links that cannot be reached, a moving joint without axis or limit, a moving link
/// without mass, an inertia that violates the triangle inequality, a missing mesh file.
UrdfTree ReadUrdf(const std::filesystem::path& file, const std::map<std::string, double>& masses);

}  // namespace gaitcam
