#include "algorithms/features/mobif_restore.h"

namespace gaitcam {
namespace {

class MobifRestore : public BlurAwareFeature {
 public:
  explicit MobifRestore(const MobifRestoreOptions& options) : options_(options) {
    CheckFields(options_);
    psf_ = MakePsfEstimator(options_.psf);
  }

  int descriptorSize() const override { return SiftLength(options_.sift); }

 private:
  Features Extract(const cv::Mat& grey, int most) override {
    const std::vector<BlurRegion> known = KnownRegions(grey.size());
    const LineBlur blur = known.empty() ? psf_->EstimateWhole(grey).blur : known.front().estimate.blur;  // 5.2.1
    cv::Mat light;
    grey.convertTo(light, CV_32F, 1 / 255.0);
    if (blur.extent_px >= options_.min_extent_px) light = RestoreWiener(light, blur, options_.wiener);  // 5.2.2
    const ScaleSpace space = BuildScaleSpace(light, options_.scale_space);                              // 5.2.3
    return DescribeSift(space, DetectHessian(space, options_.hessian), options_.sift, most);            // 5.2.4
  }

  const MobifRestoreOptions options_;
  std::unique_ptr<PsfEstimator> psf_;
};

}  // namespace

cv::Ptr<BlurAwareFeature> MakeMobifRestore(const MobifRestoreOptions& options) {
  return cv::makePtr<MobifRestore>(options);
}

}  // namespace gaitcam
