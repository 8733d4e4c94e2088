#include "algorithms/features/wiener.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// H W = H^2 / (H^2 + gamma): the blurred image that the restored one explains.
class ExplainedTransfer : public TransferFunction {
 public:
  ExplainedTransfer(const LineBlur& blur, const WienerOptions& options) : line_(blur), wiener_(blur, options) {}
  void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const override {
    Eigen::ArrayXf h(fx.size());
    line_.Row(fx, fy, h);
    wiener_.Row(fx, fy, out);
    out *= h;
  }

 private:
  LineTransfer line_;
  WienerTransfer wiener_;
};

}  // namespace

WienerTransfer::WienerTransfer(const LineBlur& blur, const WienerOptions& options)
    : line_(blur), gamma_(float(options.gamma)), slope_(float(options.gamma_slope)) {
  CheckFields(options);
}

void WienerTransfer::Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const {
  line_.Row(fx, fy, out);
  out = out / (out.square() + (gamma_ + slope_ * (fx.square() + fy * fy)));
}

cv::Mat RestoreWiener(const cv::Mat& image, const LineBlur& blur, const WienerOptions& options) {
  constexpr int kLeastMargin_px = 32;  // room for the margin to fade
  const int margin = std::max(kLeastMargin_px, int(std::ceil(blur.extent_px)));
  Spectrum spectrum(image, margin);
  const ExplainedTransfer explained(blur, options);
  for (int pass = 0; pass < options.border_passes; ++pass) spectrum.RefillMargin(explained);
  return spectrum.Through(WienerTransfer(blur, options));
}

}  // namespace gaitcam
