#include "sim/camera/auto_exposure.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

void AutoExposureOptions::Check() const {
  CheckFields(*this, "camera.auto_exposure.");
  if (max_ms < min_ms) {
    throw BadOption("camera.auto_exposure.max_ms: " + internal::NumberText(max_ms) +
                    " is not permitted; expected at least camera.auto_exposure.min_ms, " +
                    internal::NumberText(min_ms));
  }
}

AutoExposure::AutoExposure(const AutoExposureOptions& options, double first_ms, double reference_ms)
    : options_(options),
      reference_ms_(reference_ms),
      product_ms_(std::clamp(first_ms, options.min_ms, options.max_ms)) {
  options.Check();
}

double AutoExposure::exposure_ms() const { return std::clamp(product_ms_, options_.min_ms, options_.max_ms); }

double AutoExposure::gain() const { return std::clamp(product_ms_ / exposure_ms(), 1.0, options_.max_gain); }

void AutoExposure::Measure(double luminance) {
  constexpr double kDark = 1e-6;  // a lens cap: the control runs to its end
  const double mean = std::max(kDark, luminance * product_ms_ / reference_ms_);
  product_ms_ = std::clamp(product_ms_ * std::pow(options_.target / mean, options_.speed), options_.min_ms,
                           options_.max_ms * options_.max_gain);
}

}  // namespace gaitcam
