/// Conversion between display values and linear light. OpenGL's images hold display values (sRGB); only linear values
/// may be averaged.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace gaitcam {

/// IEC 61966-2-1: display value in [0, 1] to linear light in [0, 1], and back.
double SrgbToLinear(double display);
double LinearToSrgb(double linear);

/// Sums pictures as light, each with its weight, in single precision.
class LightAccumulator {
 public:
  LightAccumulator(int width_px, int height_px) : light_(height_px, width_px, CV_32FC3, cv::Scalar::all(0)) {}

  /// Pictures are CV_8UC4, display values, bottom row first, as Renderer::ReadColor gives them.
  void Add(const cv::Mat& bgrx_bottom_up, float weight);
  /// Each row with its own weight; row 0 is the top row. Rows of weight 0 cost nothing.
  void Add(const cv::Mat& bgrx_bottom_up, std::span<const float> row_weights);
  /// As a lens bends it: pixel (u, v) takes what the picture shows at `map`(v, u) (CV_32FC2), between four pixels that
  /// each look `shift_px` beside their centres. Interpolating every picture for itself, and not their sum, keeps the
  /// sum free of the beat between two rasters: it is as if seen through one tent-shaped pixel, two pixels wide,
  /// everywhere.
  void AddBent(const cv::Mat& bgrx_bottom_up, const cv::Mat& map, const Eigen::Vector2d& shift_px,
               std::span<const float> row_weights);

  /// CV_32FC3 (BGR), linear light, 1 is display white; row 0 on top.
  const cv::Mat& light() const { return light_; }

 private:
  void AddRow(const cv::Mat& bgrx_bottom_up, int row, const float* table);
  cv::Mat light_;
};

/// Light of a picture in which `finer` x `finer` pixels make one of the image: their mean. CV_32FC3 (BGR), row 0 on
/// top.
/// @param bgrx_bottom_up as LightAccumulator takes them.
cv::Mat MeanLight(const cv::Mat& bgrx_bottom_up, int finer);

/// Mean luminance (Rec. 709) of a picture, linear, of every fourth pixel along and across: as a light meter needs it.
double MeanLuminance(const cv::Mat& bgrx_bottom_up);
/// The same of light, CV_32FC3 (BGR).
double MeanLuminanceOfLight(const cv::Mat& light);

/// Light of each pixel of a picture, CV_32FC4 (BGR and nothing), row 0 on top: four lanes for vector arithmetic.
void DecodeLight(const cv::Mat& bgrx_bottom_up, cv::Mat& light);

/// Light to 8-bit display values, clipped and rounded; any number of channels.
cv::Mat EncodeSrgb(const cv::Mat& light);

/// `count` points spread evenly over a pixel, [-0.5, 0.5) in x and y, of mean zero; neighbours in the list lie far
/// apart. Each axis is stratified: cut into `count` equal parts, every part holds one point. The order is that of
/// Roberts's R2 sequence ("The unreasonable effectiveness of quasirandom sequences", 2018), so that any run of them is
/// spread as well.
std::vector<Eigen::Vector2d> PixelShifts(int count);

}  // namespace gaitcam
