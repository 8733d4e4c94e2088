/// What a depth camera beside the left one measures, registered to its pixels: true depth, spoilt as a sensor spoils
/// it.
///
/// `structured_light` (Kinect v1): a projector 75 mm to the camera's right casts a pattern; its disparity f b / z, f b
/// = 580 px * 0.075 m, is read in eighths of a pixel. Khoshelham and Elberink, "Accuracy and resolution of Kinect depth
/// data for indoor mapping applications", Sensors 2012, found half such a step of noise, quantisation included:
/// sigma_z = 1.425e-5 z^2 (cm), 1.4 mm at 1 m and 3.6 cm at 5 m. There is no reading
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
/// Both look at mid-exposure of the left camera, for an instant: depth is not smeared by motion. Readings are whole
/// millimetres.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/camera.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/random.h"

namespace gaitcam {

enum class DepthModel { kIdeal, kStructuredLight, kTimeOfFlight };
constexpr auto WordsOf(DepthModel) {
  return std::array{EnumWord{DepthModel::kIdeal, "ideal"}, EnumWord{DepthModel::kStructuredLight, "structured_light"},
                    EnumWord{DepthModel::kTimeOfFlight, "time_of_flight"}};
}
/// A resolved scenario does not show the ideal one.
inline bool SaysNothing(DepthModel model) { return model == DepthModel::kIdeal; }

/// As the data sheet says: of time of flight, on a surface that reflects half of the light.
DepthCalibration DepthDataSheet(DepthModel model);

/// @param depth CV_32FC1, m along the optical axis, 0 where nothing is. @param rays CV_32FC2 of the same size: X/Z and
/// Y/Z at each pixel. @param image of the same size, CV_8UC1 or CV_8UC3, sRGB. @param noise this frame's own.
/// @returns CV_32FC1, m; 0 where nothing was measured.
cv::Mat MeasureDepth(DepthModel model, const cv::Mat& depth, const cv::Mat& rays, const cv::Mat& image,
                     RandomStream noise);

}  // namespace gaitcam
