/// What the errors of landmarks add to the motion between frames that are localised against them: nothing as long as
/// the camera stays where the landmarks were seen from, the more the farther it goes.

#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/se3.h"
#include "algorithms/odometry/stereo_map.h"

namespace gaitcam {

/// A pose, and how its error comes from that of each landmark.
struct LandmarkGains {
  Pose X_WC;
  std::map<int, Eigen::Matrix<double, 6, 3>> by_landmark;  ///< d tau / d p_W (RigPoseResult::by_point).
};

/// What landmarks add to the motion between two frames, in the later one's tangent: of those that both use much
/// cancels. Positive semidefinite.
Matrix6d DifferenceOfLandmarks(const LandmarkGains& before, const LandmarkGains& now,
                               const std::vector<StereoLandmark>& landmarks);

/// A covariance of poses, one after the other, that never shrinks: a head that sways back does not know what it did not
/// know before, and a motion's covariance is the difference of those of its ends.
class GrowingCovariance {
 public:
  /// The next pose, whose covariance is this by itself.
  void Add(const Pose& X_WC, const Matrix6d& covariance);

  /// Of the last pose, in its tangent: no less than any of the poses' own. Positive semidefinite.
  const Matrix6d& covariance() const { return covariance_; }
  /// How much of another covariance, positive definite, that is: 0 to 1.
  double ShareOf(const Matrix6d& whole) const;

 private:
  Pose last_;
  Matrix6d covariance_ = Matrix6d::Zero();
};

}  // namespace gaitcam
