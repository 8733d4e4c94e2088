/// From light to an 8-bit image, as a sensor does it: gain, photon shot noise, read noise, analogue-digital converter,
/// response curve.
///
/// A display-white surface (light 1) frees E = full_well_e * min(1, s t / t_ref) electrons ("auto" gain) or
/// full_well_e * s t / t_ref ("fixed") during the exposure t in a scene of light level s. A pixel of light L then reads
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

/// What decides brightness and noise of one frame.
struct Amplification {
  double white_e = 0;  ///< Electrons that a display-white surface frees.
  double gain = 1;     ///< Code value of an electron, in those of a full well over its electrons.
};

class ImageSensor {
 public:
  /// @param grey a monochrome sensor: one channel, of the luminance (Rec. 709).
  /// @param light_level of the scene (Scene::light), > 0.
  ImageSensor(const ExposureOptions& options, bool grey, double light_level = 1);

  /// @param light CV_32FC3 (BGR), linear, 1 is display white.
  /// @param noise one stream per frame, so that a frame's noise does not depend on the frames before it.
  /// @returns CV_8UC3, or CV_8UC1 if grey.
  cv::Mat Develop(const cv::Mat& light, RandomStream noise) const { return Develop(light, noise, amplification_); }
  cv::Mat Develop(const cv::Mat& light, RandomStream noise, const Amplification& amplification) const;
  /// The same without noise.
  cv::Mat DevelopNoiseless(const cv::Mat& light) const { return DevelopNoiseless(light, amplification_); }
  cv::Mat DevelopNoiseless(const cv::Mat& light, const Amplification& amplification) const;

  /// By the options' exposure and gain.
  const Amplification& amplification() const { return amplification_; }
  double white_e() const { return amplification_.white_e; }
  double gain() const { return amplification_.gain; }
  /// Of another exposure and a gain chosen for it: nothing is kept at a brightness.
  Amplification AmplificationAt(double exposure_ms, double gain) const;

 private:
  cv::Mat ToChannels(const cv::Mat& light) const;

  ExposureOptions options_;
  bool grey_;
  double light_level_;
  Amplification amplification_;
  std::vector<float> normals_;     ///< Quantiles of the standard normal distribution, looked up by 16 random bits.
  std::vector<uint8_t> response_;  ///< From kResponseSteps + 1 equal steps of linear light to the 8-bit code.
};

}  // namespace gaitcam
