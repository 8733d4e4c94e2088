/// Pairs of frames of a recorded walk with their true relation, for research on matching and deblurring:
/// blurred, sharp, blur vectors, the floor's homography, and true points.
///
/// One folder per pair, TRUTH/pairs/NNNNNN_MMMMMM (numbers of its frames, from 0), in it
///
///   a.png b.png              the blurred images, as the sensors' folder has them
///   a_sharp.png b_sharp.png  sharp twins: one instant at mid-exposure
///   a_blur.png b_blur.png    blur vectors, coded as in dataset_layout.h
///   H_floor.txt              3 x 3, row by row: maps floor points of a to b, for undistorted pixels (K of the
///                            calibration, no distortion); without lens distortion these are the image's own pixels
///   points.csv               a_x, a_y, b_x, b_y (px of the images as they are, distortion included), X, Y, Z (m,
///                            world), floor (1: on the floor)
///   pair.txt                 stamps, frame numbers, poses X_WC and median blur of both
///
/// and TRUTH/pairs/pairs.csv, one row per pair. All of it holds at mid-exposure.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "algorithms/core/fields.h"
#include "scenarios/code/runs/recorded_walk.h"

namespace gaitcam {

struct PairOptions {
  using DescribedTag = void;
  bool enabled = false;
  int every = 10;
  int gap = 3;
  int points = 400;
};

template <class Visitor>
void VisitFields(Visitor& visit, PairOptions& o) {
  visit("enabled", o.enabled, Nested(), "write pairs of frames with what is true between them");
  visit("every", o.every, Between(1, 1000000), "a pair begins at every n-th frame");
  visit("gap", o.gap, Between(1, 100000), "frames from the first to the second");
  visit("points", o.points, Between(1, 1000000),
        "true points per pair, on a grid over the first image; those not seen in the second are left out");
}

/// A point visible in both frames.
struct TruePointPair {
  Eigen::Vector2d a, b;  ///< px of the images as they are.
  Eigen::Vector3d p_W;   ///< m
  bool on_floor = false;
};

/// Maps the plane z = 0 of the world from camera a's image to camera b's, scaled so that its last entry is 1:
///   H = K (R_BA + t_BA n^T / d) K^-1, the floor being n^T p = d in a's frame (Hartley and Zisserman, 13.2).
/// Pixels are undistorted ones: K without the lens's distortion.
Eigen::Matrix3d FloorHomography(const CameraModel& camera, const Pose& X_WA, const Pose& X_WB);

/// Points on a grid of pixels of a, back-projected by a's depth and projected into b; kept where b's depth agrees to 1
/// %, that is where the point is not occluded.
std::vector<TruePointPair> MatchPoints(const CameraModel& camera, const Pose& X_WA, const cv::Mat& depth_a,
                                       const Pose& X_WB, const cv::Mat& depth_b, int wanted);

/// Writes TRUTH/pairs. @returns how many pairs. @throws BadInput if the recording has no truth images;
/// MissingResource.
int WriteFramePairs(const RecordedWalk& walk, const PairOptions& options);

}  // namespace gaitcam
