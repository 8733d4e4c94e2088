#include "algorithms/features/mobif.h"

#include "algorithms/features/adapted_gaussian.h"
#include "algorithms/features/psf.h"

namespace gaitcam {
namespace {

class Mobif : public BlurAwareFeature {
 public:
  explicit Mobif(const MobifOptions& options) : options_(options) {
    CheckFields(options_);
    psf_ = MakePsfEstimator(options_.psf);
  }

 private:
  Features Extract(const cv::Mat& grey) override {
    cv::Mat light;
    grey.convertTo(light, CV_32F, 1 / 255.0);
    const ScaleSpace space = AdaptedTo(Estimate(grey), light);
    return DescribeSift(space, DetectHessian(space, options_.hessian), options_.sift);
  }

  BlurEstimate Estimate(const cv::Mat& grey) const {
    constexpr double kSharp_px = 2;
    if (known_blur()) return {*known_blur(), 1, known_blur()->extent_px > kSharp_px};
    return psf_->EstimateWhole(grey);
  }

  ScaleSpace AdaptedTo(const BlurEstimate& estimate, const cv::Mat& light) {
    if (!estimate.blurred) return BuildScaleSpace(light, options_.scale_space);
    if (estimate.confidence >= options_.restore_confidence)
      return BuildScaleSpace(RestoreWiener(light, estimate.blur, options_.wiener), options_.scale_space);
    ScaleSpaceOptions single = options_.scale_space;
    single.first_doubled = false;
    return BuildAdaptedScaleSpace(light, estimate.blur, single, adapted_sigma_);
  }

  const MobifOptions options_;
  std::unique_ptr<PsfEstimator> psf_;
  AdaptedSigmaCache adapted_sigma_;  // the same values in whatever order they are asked for
};

}  // namespace

MobifOptions::MobifOptions() {
  sift.root = true;
  hessian.threshold = 2e-4;
  hessian.compact = true;
}

MobifOptions MobifFastOptions() { return MobifOptions(); }

cv::Ptr<BlurAwareFeature> MakeMobif(const MobifOptions& options) { return cv::makePtr<Mobif>(options); }

}  // namespace gaitcam
