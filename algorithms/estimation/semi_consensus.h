/// How a chain of poses gives way to what loop closures say of its last one.
///
/// Source: Hua, section 6.1.1.2, Eqs. 6.2 to 6.4.

#pragma once

#include <span>
#include <vector>

#include "algorithms/core/se3.h"

namespace gaitcam {

/// What one loop says of a pose.
struct LikelyPose {
  Pose X;
  Matrix6d covariance;
};

/// Eq. 6.2: the pose whose sum of squared Mahalanobis distances from all of them is least, by Gauss-Newton.
/// @pre one or more; covariances are positive definite.
Pose MahalanobisMean(const std::vector<LikelyPose>& poses);

/// Eqs. 6.3 and 6.4: moves `chain` so that its last pose goes the part `alpha` of the way to `closed`, and each
/// relative pose after the first takes an equal share. The first pose stays.
///
/// The text leaves open in which frame the difference is given. Here it is the motion of the world that takes the last
/// pose to the closed one, D = closed last^-1: each relative pose R_k takes the part alpha / (b - a) of D as seen from
/// its own model, R_k Exp(L_k^-1 . Log(D) alpha / (b - a)). These parts add up, so that alpha = 1 closes the loop
/// exactly however the chain is bent.
/// @param alpha from 0 to 1.
void ReachSemiConsensus(std::span<Pose> chain, const Pose& closed, double alpha);

}  // namespace gaitcam
