/// What is true of one frame, as far as it is known: from the simulator, or from the truth folder of a recording.
///
/// Never shown to an estimator: in `algorithms`, `io` alone may include this file (tests/house/layering_test.cpp).

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"

namespace gaitcam {

enum class SupportPhase { kDouble, kLeft, kRight };

/// Where in the gait a robot is.
struct GaitState {
  int step = -1;                                 ///< Index of the current step; -1 while standing.
  double phase = 0;                              ///< 0..1 within the step.
  SupportPhase support = SupportPhase::kDouble;  ///< As planned.
};

/// Numbers alone; some 500 bytes.
struct FrameTruth {
  int64_t stamp_ns = 0;                                         ///< Middle of the exposure.
  Pose X_WC_open, X_WC, X_WC_close;                             ///< Left camera at shutter open, middle and close (of
                                                                ///< the middle row).
  std::optional<Pose> X_WI;                                     ///< IMU at mid-exposure.
  std::optional<Pose> X_WB;                                     ///< The robot's root at mid-exposure.
  double blur_median_px = 0, blur_p90_px = 0, blur_max_px = 0;  ///< Path lengths of image points over the image.
  std::optional<GaitState> gait;
  bool left_contact = false, right_contact = false;  ///< Of the feet with the floor, at the shutter's close.
};

/// One instant of an exposure: when, how much it counts, and where the camera was.
struct Subframe {
  int64_t stamp_ns = 0;
  double weight = 0;  ///< Sums to 1 over the frame (global shutter; per row for a rolling one).
  Pose X_WC;
};

/// With everything that the image was made of. Pictures may be empty.
struct FilmedTruth : FrameTruth {
  std::vector<Subframe> subframes;
  int renders = 0;  ///< How many pictures were rendered for the image; the other sub-frames were computed from them.
  cv::Mat sharp;    ///< CV_8UC1 or CV_8UC3: one instant at mid-exposure, same optics and response, no noise.
  cv::Mat depth;    ///< CV_32FC1, m along the optical axis at mid-exposure; 0 where nothing is.
  cv::Mat blur;     ///< CV_32FC2, px: how far the point seen here moved from shutter open to close (net vector); NaN
                    ///< where unknown.
};

}  // namespace gaitcam
