/// From light to an 8-bit image, as a sensor does it: gain, photon shot noise, read noise, analogue-digital converter,
/// response curve.
///
/// A display-white surface (light 1) frees E = full_well_e * min(1, t / t_ref) electrons ("auto" gain) or
/// full_well_e * t / t_ref ("fixed") during the exposure t. A pixel of light L then reads
///   e = L E + noise * sqrt(L E + read_noise_e^2) * n,  n standard normal,
/// clipped to the full well, amplified by the gain (full_well_e / E when auto, 1 when fixed) and digitised to 12 bits.
/// The normal distribution stands in for Poisson's, which differs from it only where the read noise hides the
/// difference. Auto gain never attenuates: at exposures above t_ref the lens is closed further until white just fills
/// the well. An exposure of 0 stands for one instant with the reference exposure's light.

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/random.h"
#include "sim/camera/exposure_options.h"

namespace gaitcam {

class ImageSensor {
 public:
  /// @param grey a monochrome sensor: one channel, of the luminance (Rec. 709).
  ImageSensor(const ExposureOptions& options, bool grey);

  /// @param light CV_32FC3 (BGR), linear, 1 is display white.
  /// @param noise one stream per frame, so that a frame's noise does not depend on the frames before it.
  /// @returns CV_8UC3, or CV_8UC1 if grey.
  cv::Mat Develop(const cv::Mat& light, RandomStream noise) const;
  /// The same without noise.
  cv::Mat DevelopNoiseless(const cv::Mat& light) const;

  /// Electrons that a display-white surface frees.
  double white_e() const { return white_e_; }
  /// Code value of a full well divided by that of `white_e`.
  double gain() const { return gain_; }

 private:
  cv::Mat ToChannels(const cv::Mat& light) const;

  ExposureOptions options_;
  bool grey_;
  double white_e_ = 0, gain_ = 1;
  std::vector<float> normals_;     ///< Quantiles of the standard normal distribution, looked up by 16 random bits.
  std::vector<uint8_t> response_;  ///< From kResponseSteps + 1 equal steps of linear light to the 8-bit code.
};

}  // namespace gaitcam
