/// What lenses that are calibrated a little wrong do to the motions that a stereo rig measures.
///
/// The errors are the same in all images. So they neither average out nor grow like a random walk, and the motion from
/// one frame to the next shows next to nothing of them: they need a place of their own beside a covariance.

#pragma once

#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/rig_pose.h"
#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// What errors of one standard deviation do to a pose, a column for each of LensUncertainty: focal length, the
/// principal point's x and y, the right focal length alone. Tangent of se3.h: m, rad.
using LensErrors = Eigen::Matrix<double, 6, 4>;

/// The same points as two frames saw them, with both cameras, in normalised coordinates. Of equal number.
struct PointsInBoth {
  std::vector<RigSighting> A, B;  ///< Positions are not used.
};

/// Those of the motion from A to B: the most likely motion (RefineStereoMotion) by the images as they are, against that
/// by images which each error moves. Of many points, a part that is spread over them is used.
/// @returns zero where there are too few points to say so
LensErrors LensErrorsOfMotion(const PointsInBoth& points, const StereoRig& rig, const Pose& X_AB,
                              const LensUncertainty& lens);

/// Those of X_WB, from those of X_WA and of the motion from A to B.
inline LensErrors ChainLensErrors(const LensErrors& of_A, const Pose& X_AB, const LensErrors& of_motion) {
  return Adjoint(X_AB.Inverse()) * of_A + of_motion;
}

}  // namespace gaitcam
