#include "algorithms/features/mobif_adapt.h"

#include <opencv2/imgproc.hpp>

#include "algorithms/features/adapted_gaussian.h"
#include "algorithms/features/descriptor_entropy.h"

namespace gaitcam {
namespace {

class MobifAdapt : public BlurAwareFeature {
 public:
  explicit MobifAdapt(const MobifAdaptOptions& options) : options_(options) { CheckFields(options_); }

  int descriptorSize() const override { return SiftLength(options_.sift); }

 private:
  Features Extract(const cv::Mat& grey, int) override {
    cv::Mat light;
    grey.convertTo(light, CV_32F, 1 / 255.0);
    Features all;
    all.descriptors = cv::Mat(0, descriptorSize(), CV_32FC1);
    for (const BlurRegion& region : Regions(grey)) {
      const Features part = ExtractRegion(light, region);
      all.keypoints.insert(all.keypoints.end(), part.keypoints.begin(), part.keypoints.end());
      all.descriptors.push_back(part.descriptors);
    }
    return options_.discard_low_entropy ? DiscardLowEntropy(all) : all;  // 5.3.2
  }

  std::vector<BlurRegion> Regions(const cv::Mat& grey) const {  // 5.3.1
    const std::vector<BlurRegion> known = KnownRegions(grey.size());
    return known.empty() ? SegmentBlur(grey, options_.segmentation) : known;
  }

  /// Features whose keypoints lie in the region, from the region and a margin around it.
  Features ExtractRegion(const cv::Mat& light, const BlurRegion& region) {
    const int m = options_.margin_px;
    const cv::Rect seen =
        (region.rectangle + cv::Size(2 * m, 2 * m) - cv::Point(m, m)) & cv::Rect({0, 0}, light.size());
    const LineBlur blur = region.estimate.blurred ? region.estimate.blur : LineBlur();
    const ScaleSpace space = BuildAdaptedScaleSpace(light(seen), blur, options_.scale_space, adapted_sigma_);
    const std::vector<ScalePoint> points = DetectHessian(space, options_.hessian, region.rectangle - seen.tl());
    Features features = DescribeSift(space, points, options_.sift);
    for (cv::KeyPoint& k : features.keypoints) k.pt += cv::Point2f(seen.tl());
    return features;
  }

  const MobifAdaptOptions options_;
  AdaptedSigmaCache adapted_sigma_;  // the same values in whatever order they are asked for
};

}  // namespace

cv::Ptr<BlurAwareFeature> MakeMobifAdapt(const MobifAdaptOptions& options) { return cv::makePtr<MobifAdapt>(options); }

}  // namespace gaitcam
