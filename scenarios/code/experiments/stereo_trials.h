/// Monte Carlo of stereo reconstruction and of the motion between two pairs, and how it compares with what is
/// propagated (Valencia, section 2.3.3).

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/random.h"
#include "algorithms/geometry/error_propagation.h"
#include "algorithms/geometry/rigid_motion.h"
#include "algorithms/geometry/stereo_reconstruction.h"

namespace gaitcam {

/// The chapter's rig, with lenses that it does not state: 640 x 480 pixels over 60 degrees without distortion.
/// @param baseline_m replaces the chapter's 0.385 m along x; 0: leaves it
StereoRig ValenciaRig(double baseline_m = 0);

/// The motion that is measured: between two frames of a walk, say. 15 cm forward, 3 cm aside, some 2 degrees.
Pose StepOfTrials();

/// Where a point is seen without error, with equal covariances of both images. @param sigma_px of each coordinate
StereoSighting ExactSighting(const StereoRig& rig, const Eigen::Vector3d& p_L, double sigma_px);
/// The sighting with Gaussian errors of its covariances.
StereoSighting WithNoise(const StereoSighting& sighting, RandomStream& random);

/// What both pairs see of points: in the first pair's frame A, and in the second's, B.
struct SceneSightings {
  StereoRig rig;
  Pose X_AB;
  std::vector<StereoSighting> A, B;

  int size() const { return int(A.size()); }
};
/// Points uniform in the left image and in depth that all four cameras see.
SceneSightings DrawScene(const StereoRig& rig, const Pose& X_AB, int points, double near_m, double far_m,
                         double sigma_px, RandomStream& random);
SceneSightings WithNoise(const SceneSightings& scene, RandomStream& random);

/// e^T P^-1 e; NaN if the covariance is singular.
template <int N>
double SquaredNorm(const Eigen::Matrix<double, N, 1>& e, const Eigen::Matrix<double, N, N>& covariance);

/// The chapter's test of a point: samples around where the exact pixels are, reconstructed by Eq. 2.26, their NEES by
/// Eq. 2.32 summed. `mu` and the covariance are those of the exact pixels.
double PointNeesSum(const StereoRig& rig, const StereoSighting& exact, int samples, RandomStream& random);

/// Without the points that lie behind a camera by noise, in either frame.
SceneSightings Reconstructible(const SceneSightings& scene);

/// The chapter's test of a motion (Eqs. 2.4, 2.30, 2.32), by the SVD; d in x, y, z, roll, pitch, yaw.
/// @param poses receives the samples' d if it is given.
double MotionNeesSum(const SceneSightings& exact, int samples, RandomStream& random,
                     std::vector<Vector6d>* poses = nullptr);

/// All points of a scene reconstructed; those that are not are left out, in both frames.
std::vector<StereoPointMatch> Reconstruct(const SceneSightings& scene, const ReconstructionOptions& options);
std::vector<PointMatch> MatchesOf(const std::vector<StereoPointMatch>& points);

}  // namespace gaitcam
