/// Alignment of an estimate with the truth.
///
/// Least squares over positions in closed form: S. Umeyama, "Least-squares estimation of transformation parameters
/// between two point patterns", IEEE PAMI 13(4), 1991. Where positions leave the rotation undetermined (a path along
/// a line, or a pure rotation) orientations determine the rest; the position error is the same for every choice.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "algorithms/core/pose.h"
#include "results/scoring/association.h"

namespace gaitcam {

enum class Alignment {
  kNone,  ///< Compare as given.
  kSe3,   ///< Rotation and translation: 6 degrees of freedom.
  kSim3,  ///< Scale as well: 7 degrees of freedom, for monocular systems.
  kYaw,   ///< Rotation about the vertical and translation: 4 degrees of freedom, for systems that know gravity.
};

/// "none", "se3", "sim3", "yaw".
std::string ToString(Alignment alignment);

/// p_W = scale * R * p_V + translation.
struct Similarity {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return scale * (rotation * p) + translation; }
  /// The pose with its position mapped and its orientation rotated (which scale does not touch).
  Pose operator*(const Pose& pose) const;
};

struct AlignmentResult {
  Similarity X_WV;  ///< Maps the estimator's world V into the truth's world W.
  int rank = 3;     ///< Directions in which both paths extend together: below 2 the positions leave a rotation free.
  bool scale_known = true;  ///< False if one of the paths does not extend at all, so that scale was kept at 1.

  /// One line on what was not determined by the positions; empty when all was.
  std::string Remark() const;
};

/// The transformation that minimises sum |p_truth - X * p_estimate|^2 over the pairs.
/// @pre at least one pair.
AlignmentResult Align(const std::vector<PosePair>& pairs, Alignment alignment);

/// The rotation R_WV that fits the orientations best: it minimises sum |R_truth - R R_estimate|^2 (the chordal mean of
/// R. Hartley et al., "Rotation averaging", IJCV 2013). Positions have no say in it.
/// @pre at least one pair.
Eigen::Quaterniond AlignOrientations(const std::vector<PosePair>& pairs);

/// The pairs with their estimates mapped.
std::vector<PosePair> Apply(const Similarity& X_WV, std::vector<PosePair> pairs);

}  // namespace gaitcam
