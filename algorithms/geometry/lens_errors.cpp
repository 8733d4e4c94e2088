#include "algorithms/geometry/lens_errors.h"

#include <algorithm>

#include "algorithms/geometry/stereo_motion.h"

namespace gaitcam {
namespace {

enum Error { kFocal, kCentreX, kCentreY, kRightFocal };

/// How one error moves the normalised coordinates in which an image is read.
Eigen::Vector2d Moved(const Eigen::Vector2d& xy, int error, const StereoRig& rig, bool right,
                      const LensUncertainty& lens) {
  const CameraModel& camera = right ? rig.right : rig.left;
  switch (error) {
    case kFocal: return (1 - lens.focal) * xy;
    case kCentreX: return xy - Eigen::Vector2d(lens.centre_px / camera.fx, 0);
    case kCentreY: return xy - Eigen::Vector2d(0, lens.centre_px / camera.fy);
    default: return right ? (1 - lens.right_focal) * xy : xy;
  }
}

/// A camera whose pixels are normalised coordinates.
CameraModel UnitCamera() {
  CameraModel camera;
  camera.width_px = camera.height_px = 1;
  camera.fx = camera.fy = 1;
  return camera;
}

}  // namespace

LensErrors LensErrorsOfMotion(const PointsInBoth& points, const StereoRig& rig, const Pose& X_AB,
                              const LensUncertainty& lens) {
  constexpr size_t kFewest = 12, kEnough = 120;
  if (points.A.size() < kFewest) return LensErrors::Zero();
  const StereoRig unit{UnitCamera(), UnitCamera(), rig.X_LR};
  const size_t used = std::min(points.A.size(), kEnough);
  /// @param error -1: none
  const auto motion_with = [&](int error) {
    const auto seen = [&](const RigSighting& s) {
      return error < 0 ? StereoSighting{s.left, s.right, s.covariance_left, s.covariance_right}
                       : StereoSighting{Moved(s.left, error, rig, false, lens), Moved(s.right, error, rig, true, lens),
                                        s.covariance_left, s.covariance_right};
    };
    std::vector<StereoSighting> A, B;
    for (size_t i = 0; i < used; ++i) {
      const size_t k = i * points.A.size() / used;
      A.push_back(seen(points.A[k]));
      B.push_back(seen(points.B[k]));
    }
    return RefineStereoMotion(unit, A, B, X_AB).X_AB;
  };
  const Pose without = motion_with(-1);
  LensErrors errors;
  for (const int error : {kFocal, kCentreX, kCentreY, kRightFocal})
    errors.col(error) = Minus(without, motion_with(error));
  return errors;
}

}  // namespace gaitcam
