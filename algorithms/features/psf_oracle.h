/// A known point spread function: for experiments on the sensitivity to errors of the estimate.

#pragma once

#include "algorithms/features/psf.h"

namespace gaitcam {

/// Returns what it was given, with confidence 1. `blurred` is true from `verdict_px` on.
class OraclePsf : public PsfEstimator {
 public:
  /// One blur for the whole image.
  explicit OraclePsf(const LineBlur& blur, double verdict_px = 3);
  /// Blur of each pixel.
  /// @param vectors CV_32FC2 of the image's size, px from shutter open to close; NaN where unknown.
  explicit OraclePsf(const cv::Mat& vectors, double verdict_px = 3);

  /// With one blur per pixel: the blur that differs least, squared, from those of the region (mean outer product).
  BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const override;

 private:
  LineBlur blur_;
  cv::Mat vectors_;
  double verdict_px_;
};

/// The line blur nearest to many, whose signs mean nothing: mean length, along the main axis of the vectors' scatter.
/// NaN vectors are left out; nothing but NaN gives a blur of 0.
LineBlur MeanBlur(const cv::Mat& vectors);

}  // namespace gaitcam
