/// Restoration of a blurred image with the Wiener filter (thesis, section 5.2.2, equations 5.4 to 5.6).

#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_blur.h"
#include "algorithms/features/spectrum.h"

namespace gaitcam {

struct WienerOptions {
  using DescribedTag = void;
  double gamma = 0.01;  ///< Equation 5.5: noise power over signal power, at all frequencies.
  /// Further noise over signal that grows with the frequency squared, as it does for pictures of natural scenes; at
  /// one cycle per pixel.
  double gamma_slope = 0;
  /// What lies beyond the border has been blurred into the image. The margin is made consistent with what was restored
  /// this many times; each costs two transforms. 0: mirrored.
  int border_passes = 0;
};

template <class Visitor>
void VisitFields(Visitor& visit, WienerOptions& o) {
  visit("gamma", o.gamma, Positive(), "noise power over signal power");
  visit("gamma_slope", o.gamma_slope, AtLeast(0), "part of it that grows with the frequency squared");
  visit("border_passes", o.border_passes, Between(0, 100), "times that the margin is made consistent");
}

/// W = H / (H^2 + gamma), equation 5.5; H of a line is real.
class WienerTransfer : public TransferFunction {
 public:
  WienerTransfer(const LineBlur& blur, const WienerOptions& options);
  void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const override;

 private:
  LineTransfer line_;
  float gamma_, slope_;
};

/// The image without its blur, equation 5.6.
/// @param image CV_32FC1 with its light in the units that the blur acted on (linear for a real exposure).
/// @returns the same size and type; may leave the range of `image`.
cv::Mat RestoreWiener(const cv::Mat& image, const LineBlur& blur, const WienerOptions& options);

/// The same along a path: conj(H) / (|H|^2 + gamma). What the path calls the pixel's own place is where it is put.
/// @param path not empty.
cv::Mat RestoreWiener(const cv::Mat& image, const BlurPath& path, const WienerOptions& options);

/// The same where parts of the image have a blur, or a path, of their own. Each part is restored with some of its
/// surroundings; neighbours fade into each other over `kSeam_px` on either side of their border.
/// @param regions that cover the image. One whose estimate is not `blurred` stays as it is.
cv::Mat RestoreRegions(const cv::Mat& image, const std::vector<BlurRegion>& regions, const WienerOptions& options);
constexpr int kSeam_px = 8;

}  // namespace gaitcam
