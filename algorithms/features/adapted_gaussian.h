/// Gaussians that compensate motion blur: narrower along the blur, so that blur and Gaussian together approximate an
/// isotropic Gaussian (thesis, section 5.3, equations 5.12 to 5.16).

#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "algorithms/features/line_blur.h"
#include "algorithms/features/scale_space.h"

namespace gaitcam {

/// sigma' of equation 5.16: the standard deviation along the blur for which g'(sigma', sigma) * h is nearest to
/// g(sigma), by Levenberg-Marquardt over the kernels' samples. `sigma` for no blur; towards 0 for a blur too long
/// (extent > sqrt(12) sigma) to be compensated.
/// @param sigma, extent_px in the same pixels; sigma > 0.
double AdaptedSigma(double sigma, double extent_px);

/// AdaptedSigma, cached. Extents are rounded to 1/20 px, so that a value does not depend on earlier calls.
class AdaptedSigmaCache {
 public:
  double operator()(double sigma, double extent_px);

 private:
  std::map<std::pair<double, int>, double> known_;
};

/// The adapted scale space of an image or of a part of it: equation 5.11 with g' of equation 5.16, rotated into the
/// blur's direction, at the resolution of each octave.
/// @param image CV_32FC1.
/// @param options `first_doubled` is not supported here.
ScaleSpace BuildAdaptedScaleSpace(const cv::Mat& image, const LineBlur& blur, const ScaleSpaceOptions& options,
                                  AdaptedSigmaCache& cache);

}  // namespace gaitcam
