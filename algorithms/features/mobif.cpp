#include "algorithms/features/mobif.h"

#include <algorithm>

#include "algorithms/features/adapted_gaussian.h"
#include "algorithms/features/light_response.h"
#include "algorithms/features/psf.h"

namespace gaitcam {
namespace {

class Mobif : public BlurAwareFeature {
 public:
  explicit Mobif(const MobifOptions& options) : options_(options) {
    CheckFields(options_);
    psf_ = MakePsfEstimator(options_.psf);
  }

  int descriptorSize() const override { return SiftLength(options_.sift); }

 private:
  Features Extract(const cv::Mat& grey) override {
    const ScaleSpace space = WithoutBlur(grey, Estimate(grey));
    HessianOptions hessian = options_.hessian;
    hessian.max_points =
        std::min(hessian.max_points, int(options_.points_per_megapixel * 1e-6 * double(grey.total())) + 1);
    return DescribeSift(space, DetectHessian(space, hessian), options_.sift);
  }

  BlurEstimate Estimate(const cv::Mat& grey) const {
    if (known_blur()) return {*known_blur(), 1, known_blur()->extent_px >= options_.least_extent_px};
    return psf_->EstimateWhole(grey);
  }

  /// Restored, adapted or as it is.
  ScaleSpace WithoutBlur(const cv::Mat& grey, const BlurEstimate& estimate) {
    const LineBlur& blur = estimate.blur;
    if (!estimate.blurred || blur.extent_px < options_.least_extent_px)
      return BuildScaleSpace(Unchanged(grey), options_.scale_space);
    if (estimate.confidence >= options_.restore_confidence)
      return BuildScaleSpace(Restored(grey, blur), options_.scale_space);
    return BuildAdaptedScaleSpace(Unchanged(grey), blur, options_.scale_space, adapted_sigma_);
  }

  cv::Mat Restored(const cv::Mat& grey, const LineBlur& blur) const {
    const bool of_light = options_.light == "linear" || (options_.light == "auto" && BlurActedOnLight(grey, blur));
    if (of_light) return GreyOfLight(RestoreWiener(LightOfGrey(grey), blur, options_.wiener));
    return RestoreWiener(Unchanged(grey), blur, options_.wiener);
  }

  /// Grey values from 0 to 1.
  static cv::Mat Unchanged(const cv::Mat& grey) {
    cv::Mat values;
    grey.convertTo(values, CV_32F, 1 / 255.0);
    return values;
  }

  const MobifOptions options_;
  std::unique_ptr<PsfEstimator> psf_;
  AdaptedSigmaCache adapted_sigma_;  // the same values in whatever order they are asked for
};

}  // namespace

MobifOptions::MobifOptions() {
  wiener.gamma = 0.005;
  wiener.gamma_slope = 0.05;
  wiener.border_passes = 2;
  scale_space.sigma = 1.2;
  hessian.threshold = 2e-4;
  hessian.compact = true;
  hessian.saddles = true;
  sift.root = true;
  sift.kind_weight = 0.2;
}

MobifOptions MobifFastOptions() {
  MobifOptions options;
  options.wiener.border_passes = 0;
  options.scale_space.sigma = 1.4;
  options.points_per_megapixel = 8000;
  return options;
}

cv::Ptr<BlurAwareFeature> MakeMobif(const MobifOptions& options) { return cv::makePtr<Mobif>(options); }

}  // namespace gaitcam
