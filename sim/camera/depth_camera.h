/// What a depth camera beside the left one measures: true depth, spoilt as a sensor spoils it; then registered to the
/// left camera's pixels, by a calibration that is not exact, if it has a place of its own (DepthMountOptions).
///
/// `structured_light` (Kinect v1): a projector 75 mm to the camera's right casts a pattern; its disparity f b / z, f b
/// = 580 px * 0.075 m, is read in eighths of a pixel. Khoshelham and Elberink, "Accuracy and resolution of Kinect depth
/// data for indoor mapping applications", Sensors 2012, found half such a step of noise, quantisation included:
/// sigma_z = 1.425e-5 z^2 (cm), 1.4 mm at 1 m and 3.6 cm at 5 m. The pattern is matched in windows of 9 x 9 of its
/// pixels (Konolige and Mihelich, "Technical description of Kinect calibration"): neighbours share their noise as such
/// windows overlap. There is no reading
///   - nearer than 0.5 m or farther than 5 m,
///   - where the projector's light is shadowed: to the left of what stands before something else,
///   - where the surface is seen at more than 80 degrees from its normal, or steps within a pixel on either side.
/// Scenes say nothing of surfaces in infrared: none is too dark, shiny or sunlit.
///
/// `time_of_flight` (Kinect v2): with amplitude A = rho cos(incidence) (1 m / z)^2 over ambient light B the range has
/// sigma = K sqrt(A + B) / A (Lange and Seitz, "Solid-state time-of-flight range camera", IEEE JQE 2001). K and B
/// are chosen to meet Fankhauser et al., "Kinect v2 for mobile robot navigation", ICAR 2015: 1 mm at 1 m, 6 mm at 4 m
/// on a bright wall. The grey value as filmed, made linear, stands for the reflectance rho. A pixel mixes what it and
/// its neighbours see by their amplitudes, so that pixels on edges fly between two surfaces. There is no reading nearer
/// than 0.3 m, farther than 8 m, or of a sigma above 5 cm.
///
/// Both look for an instant, at mid-exposure of the left camera unless they are mounted otherwise: depth is not smeared
/// by motion. Readings are whole millimetres.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/camera.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"

namespace gaitcam {

enum class DepthModel { kIdeal, kStructuredLight, kTimeOfFlight };
constexpr auto WordsOf(DepthModel) {
  return std::array{EnumWord{DepthModel::kIdeal, "ideal"}, EnumWord{DepthModel::kStructuredLight, "structured_light"},
                    EnumWord{DepthModel::kTimeOfFlight, "time_of_flight"}};
}
/// A resolved scenario does not show the ideal one.
inline bool SaysNothing(DepthModel model) { return model == DepthModel::kIdeal; }

/// Where the depth camera really is, when it looks, and how well who registers its picture knows the former.
struct DepthMountOptions {
  using DescribedTag = void;
  double right_m = 0.025;
  double late_ms = 8;
  double error_m = 0.002;
  double error_deg = 0.2;
};

template <class Visitor>
void VisitFields(Visitor& visit, DepthMountOptions& o) {
  visit("right_m", o.right_m, Between(-0.5, 0.5), "the depth camera stands so far to the right of the left camera");
  visit("late_ms", o.late_ms, Between(0, 100), "it looks so long after mid-exposure of the left camera");
  visit("error_m", o.error_m, Between(0, 0.1),
        "standard deviation, per axis, of its place as the registration takes it, by seed");
  visit("error_deg", o.error_deg, Between(0, 5), "likewise of how it is turned");
}

/// Maps points of the depth camera into the left one: in truth, and as the registration has it.
struct DepthMount {
  Pose X_LD, X_LD_believed;

  static DepthMount Of(const DepthMountOptions& options, RandomStream errors);
};

/// A depth picture as if the left camera had taken it: each reading at the pixel that its point falls on, the nearest
/// where several do, none where none does.
/// @param depth CV_32FC1, m, 0 where nothing was measured; of a camera like `camera`. @param rays CV_32FC2: X/Z and Y/Z
/// at each pixel. @returns the same size and type.
cv::Mat RegisterDepth(const cv::Mat& depth, const cv::Mat& rays, const CameraModel& camera, const Pose& X_LD);

/// As the data sheet says: of time of flight, on a surface that reflects half of the light.
DepthCalibration DepthDataSheet(DepthModel model);

/// @param depth CV_32FC1, m along the optical axis, 0 where nothing is. @param rays CV_32FC2 of the same size: X/Z and
/// Y/Z at each pixel. @param image of the same size, CV_8UC1 or CV_8UC3, sRGB. @param noise this frame's own.
/// @returns CV_32FC1, m; 0 where nothing was measured.
cv::Mat MeasureDepth(DepthModel model, const cv::Mat& depth, const cv::Mat& rays, const cv::Mat& image,
                     RandomStream noise);

}  // namespace gaitcam
