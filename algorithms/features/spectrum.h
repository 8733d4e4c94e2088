/// An image's Fourier transform, and the image seen through a filter that is known by its transfer function.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "algorithms/features/blur_path.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// A real, even transfer function, evaluated along a row of frequencies (cycles per pixel).
class TransferFunction {
 public:
  virtual ~TransferFunction() = default;
  /// @param out as many values as `fx` has.
  virtual void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const = 0;
};

/// H of a line blur: sin(pi u) / (pi u), where u = f . (the blur's vector). Thesis, equation 5.2 transformed.
class LineTransfer : public TransferFunction {
 public:
  explicit LineTransfer(const LineBlur& blur) : vector_(blur.Vector().cast<float>()) {}
  void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const override;

 private:
  Eigen::Vector2f vector_;
};

/// A Gaussian with one standard deviation along a direction and another across it, px.
class GaussianTransfer : public TransferFunction {
 public:
  GaussianTransfer(double sigma_along, double sigma_across, double direction_rad);
  void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const override;

 private:
  float xx_, xy_, yy_;  ///< Exponent = xx fx^2 + 2 xy fx fy + yy fy^2.
};

class Spectrum {
 public:
  /// The image is put amid a margin that mirrors it and fades to its mean, so that the periodic plane has no seam.
  /// @param image CV_32FC1, not empty.
  /// @param margin_px at least, on each side.
  Spectrum(const cv::Mat& image, int margin_px);

  /// The image through a filter, every 2^octave-th pixel of it from the first on (what is above the coarser grid's
  /// limit frequency is left out): CV_32FC1, width (w - 1) / 2^octave + 1.
  cv::Mat Through(const TransferFunction& transfer, int octave = 0) const;

  /// Replaces the margin, not the image, by what the filter makes of both.
  void RefillMargin(const TransferFunction& transfer);

  /// The same with a filter that also shifts: what its phases say. @param gain on plane_size().
  cv::Mat Through(const PlaneGain& gain) const;
  void RefillMargin(const PlaneGain& gain);

  cv::Size plane_size() const { return plane_; }
  cv::Size image_size() const { return image_.size(); }

  static constexpr int kMaxOctave = 4;

 private:
  /// Periodic plane through the filter, at the resolution of an octave.
  cv::Mat Plane(const TransferFunction& transfer, int octave) const;
  cv::Mat Plane(const PlaneGain& gain) const;
  void ReplaceMargin(const cv::Mat& plane);

  cv::Mat image_;
  cv::Rect place_;  ///< Of the image in the plane; its corner and the plane's size are multiples of 2^kMaxOctave.
  cv::Size plane_;
  cv::Mat transform_;  ///< CV_32FC2; only columns up to plane width / 2 are read.
};

}  // namespace gaitcam
