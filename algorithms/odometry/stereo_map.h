/// The map of a stereo odometry: keyframes of the rig and landmarks, points of the world with a covariance, refined
/// together over the latest keyframes (algorithms/geometry/stereo_bundle.h). With them is refined how the right camera
/// stands to the left one, where that is not taken as exact.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/core/se3.h"
#include "algorithms/geometry/lens_errors.h"
#include "algorithms/geometry/rig_pose.h"
#include "algorithms/geometry/stereo_bundle.h"
#include "algorithms/odometry/stereo_view.h"

namespace gaitcam {

/// A landmark's images in one keyframe.
struct StereoObservation {
  int keyframe = 0;
  RigSighting images;  ///< Its point is not used.
};

struct StereoLandmark {
  Eigen::Vector3d p_W;
  Eigen::Matrix3d covariance_W;  ///< The keyframes taken as exact. Positive definite.
  std::vector<StereoObservation> observations;
  cv::Mat descriptor;      ///< One row, of the last keyframe that saw it; empty once it is retired.
  cv::Mat latest;          ///< One row, of the last frame that saw it; empty if that is the keyframe.
  bool determined = true;  ///< By its images as the last adjustment had them; else covariance_W is that of before.
  bool retired = false;    ///< No keyframe of the window sees it: it stays as it is and is searched for no more.
};

/// A symmetric matrix without what is negative of it, as seen by a covariance that it is a part of: neither unit nor
/// lever weighs in. Zero where `whole` is singular.
Matrix6d PositivePart(const Matrix6d& part, const Matrix6d& whole);

/// Which landmark is which left feature of a view.
struct StereoMatch {
  int landmark = -1;
  int feature = -1;
};

struct StereoMapOptions {
  int window = 10;            ///< Keyframes refined together, >= 2.
  int adjust_iterations = 8;  ///< Largest number of iterations of one adjustment.
  double outlier_sigmas = 3.5;
  double rig_rotation_deg = 0;  ///< Standard deviation of X_LR's rotation as calibrated, per axis; 0: exact.
  LensUncertainty lens;
};

class StereoMap {
 public:
  StereoMap(const StereoRig& rig, const StereoMapOptions& options);

  /// Adds a keyframe: `matches` become observations, every other left feature that has a partner a new landmark. Then
  /// the window is refined.
  /// @param use of each match, what its images are good for
  void AddKeyframe(const StereoView& view, const Pose& X_WC, const std::vector<StereoMatch>& matches,
                   const std::vector<SightingUse>& use);

  /// Updates the landmarks' latest descriptors from a frame that is no keyframe.
  void Refresh(const StereoView& view, const std::vector<StereoMatch>& matches);

  /// Landmarks whose images near `X_WC` look like features of the view; no feature is used twice.
  /// @param radius in normalised coordinates, about where each is expected
  std::vector<StereoMatch> SearchNear(const StereoView& view, const Pose& X_WC, double radius, double ratio) const;
  /// By descriptors alone.
  std::vector<StereoMatch> SearchAnywhere(const StereoView& view, double ratio) const;

  /// A match as a sighting of the landmark as it is now.
  RigSighting SightingOf(const StereoView& view, const StereoMatch& match) const;

  /// Of all landmarks that a keyframe saw and that are not retired, as (landmark, images).
  std::vector<std::pair<int, RigSighting>> SightingsOf(int keyframe) const;

  /// Retires all landmarks: the next keyframe is the first of another map in the same world.
  void Clear();

  const StereoRig& rig() const { return rig_; }  ///< X_LR as refined so far.
  const std::vector<Pose>& keyframes() const { return keyframes_; }
  const std::vector<StereoLandmark>& landmarks() const { return landmarks_; }
  bool IsEmpty() const { return first_keyframe_ == int(keyframes_.size()); }
  /// Index of the oldest keyframe that can still move.
  int WindowBegin() const;

  /// What the map adds to the error of a motion between two of its keyframes, as a covariance of the later one's pose
  /// relative to the earlier one's: it grows from keyframe to keyframe, and all frames in between share it. Positive
  /// semidefinite.
  Matrix6d GrownBetween(int from, int to) const;
  /// The same since the first keyframe, which is the world: of X_WK.
  Matrix6d SharedCovariance(int keyframe) const { return GrownBetween(0, keyframe); }
  /// What a keyframe's own images add to the error of its pose, in its tangent, the landmarks being exact. Positive
  /// semidefinite; zero where no other keyframe saw what it sees.
  Matrix6d OwnCovariance(int keyframe) const { return PointsPerError(keyframe) * own_[size_t(keyframe)]; }
  /// So many of a keyframe's points count as one, their errors hanging together.
  double PointsPerError(int keyframe) const { return points_per_error_[size_t(keyframe)]; }
  /// What the lenses' calibration does to the motion between two keyframes, beside all covariances.
  LensErrors LensErrorsBetween(int from, int to) const;
  /// The same of the motion from a keyframe K to a frame.
  /// @param sightings of landmarks in the frame, as (landmark, images); those count that K saw with both cameras, too
  LensErrors LensErrorsFrom(int keyframe, const std::vector<std::pair<int, RigSighting>>& sightings,
                            const Pose& X_KC) const;

 private:
  struct Window;
  Window MakeWindow() const;
  void Adjust();
  void TakeOver(const Window& window, const StereoBundleResult& result);
  void RemoveOutliers(const Window& window, const StereoBundleResult& result);
  void LearnRig(const StereoBundleResult& result);
  void GrowShared(const StereoBundleResult& result);
  void GrowLensErrors();
  void AddLandmarks(const StereoView& view, const Pose& X_WC, const std::vector<StereoMatch>& matches);
  bool IsKnown(const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance) const;
  void RetireUnseen();

  StereoRig rig_;
  StereoMapOptions options_;
  Pose prior_X_LR_;
  Matrix6d rig_covariance_;  ///< Of prior_X_LR_.
  int prior_keyframe_ = 0;   ///< Whose window the prior came from.
  std::vector<Pose> keyframes_;
  std::vector<Matrix6d> grown_;           ///< Of each keyframe, what came between the one before and it.
  std::vector<Matrix6d> own_;             ///< Of each keyframe, the error of its own images.
  std::vector<double> points_per_error_;  ///< Of each keyframe.
  std::vector<LensErrors> lens_errors_;   ///< Of each keyframe, of the motion from the one before it.
  int first_keyframe_ = 0;                ///< Of the present map.
  std::vector<StereoLandmark> landmarks_;
  std::vector<int> active_;  ///< Those that are not retired.
};

}  // namespace gaitcam
