#include "algorithms/features/mobif.h"

#include <algorithm>

#include "algorithms/features/adapted_gaussian.h"
#include "algorithms/features/blur_field.h"
#include "algorithms/features/descriptor_entropy.h"
#include "algorithms/features/light_response.h"
#include "algorithms/features/psf.h"
#include "algorithms/features/psf_path.h"

namespace gaitcam {
namespace {

constexpr double kSureOfLine = 0.9;  ///< A line that the image agrees with so well is not looked into further.

class Mobif : public BlurAwareFeature {
 public:
  explicit Mobif(const MobifOptions& options) : options_(options) {
    CheckFields(options_);
    psf_ = MakePsfEstimator(options_.psf);
  }

  int descriptorSize() const override { return SiftLength(options_.sift); }
  void SetMinBlur(double extent_px) override { options_.min_extent_px = extent_px; }
  void SetSaddleUse(SaddleUse use) override { saddle_use_ = use; }

 private:
  Features Extract(const cv::Mat& grey, int most) override {
    const std::vector<BlurRegion> regions = Regions(grey);
    const ScaleSpace space = WithoutBlur(grey, regions);
    const bool sharp =
        std::none_of(regions.begin(), regions.end(), [](const BlurRegion& r) { return r.estimate.blurred; });
    const double density = sharp ? options_.sharp_points_per_megapixel : options_.points_per_megapixel;
    HessianOptions hessian = options_.hessian;
    hessian.max_points = std::min(hessian.max_points, int(density * 1e-6 * double(grey.total())) + 1);
    hessian.saddles = hessian.saddles && saddle_use_ != SaddleUse::kNone;
    std::vector<ScalePoint> points = DetectHessian(space, hessian);
    if (saddle_use_ == SaddleUse::kAfterBlobs) WeakenSaddles(points, float(hessian.threshold));
    if (!options_.discard_low_entropy) return DescribeSift(space, points, options_.sift, most);
    return DiscardLowEntropy(DescribeSift(space, points, options_.sift));
  }

  /// Known, or estimated: one blur for all of the image, or a field. What is too short is taken for sharp.
  std::vector<BlurRegion> Regions(const cv::Mat& grey) const {
    std::vector<BlurRegion> regions = KnownRegions(grey.size());
    if (regions.empty() && options_.regions) regions = SegmentBlurField(grey);
    if (regions.empty()) regions = {EstimatedWhole(grey)};
    for (BlurRegion& region : regions)
      region.estimate.blurred &=
          std::max(region.estimate.blur.extent_px, region.path.Length()) >= options_.min_extent_px;
    return regions;
  }

  /// A line, or a path where no line explains the image as well and restoring along the path likely gains.
  BlurRegion EstimatedWhole(const cv::Mat& grey) const {
    const cv::Rect whole({0, 0}, grey.size());
    const BlurEstimate line = psf_->EstimateWhole(grey);
    if (!options_.paths || line.confidence >= kSureOfLine) return {whole, line};
    const PathEstimate found = EstimatePath(grey, line.blur);
    if (found.straight || found.confidence < options_.path_confidence) return {whole, line};
    return {whole, {found.path.Chord(), found.confidence, true}, found.path};
  }

  /// @param threshold that all points exceed: no saddle point does afterwards
  static void WeakenSaddles(std::vector<ScalePoint>& points, float threshold) {
    float strongest = threshold;
    for (const ScalePoint& point : points)
      if (point.kind == PointKind::kSaddle) strongest = std::max(strongest, point.response);
    for (ScalePoint& point : points)
      if (point.kind == PointKind::kSaddle) point.response *= threshold / (2 * strongest);
  }

  /// As it is, adapted or restored.
  ScaleSpace WithoutBlur(const cv::Mat& grey, const std::vector<BlurRegion>& regions) {
    const BlurRegion* blurred = nullptr;  // the largest of them
    for (const BlurRegion& region : regions)
      if (region.estimate.blurred && (!blurred || region.rectangle.area() > blurred->rectangle.area()))
        blurred = &region;
    if (!blurred) {
      ScaleSpaceOptions sharp = options_.scale_space;
      sharp.first_doubled = options_.double_sharp;
      return BuildScaleSpace(Unchanged(grey), sharp);
    }
    if (regions.size() == 1 && blurred->estimate.confidence < options_.restore_confidence)
      return BuildAdaptedScaleSpace(Unchanged(grey), blurred->estimate.blur, options_.scale_space, adapted_sigma_);
    const bool of_light = options_.light == BlurDomain::kLinear ||
                          (options_.light == BlurDomain::kAuto && ActedOnLight(grey, regions, *blurred));
    const cv::Mat restored = RestoreRegions(of_light ? LightOfGrey(grey) : Unchanged(grey), regions, options_.wiener);
    return BuildScaleSpace(of_light ? GreyOfLight(restored) : restored, options_.scale_space);
  }

  static bool ActedOnLight(const cv::Mat& grey, const std::vector<BlurRegion>& regions, const BlurRegion& largest) {
    if (!largest.path.empty()) return PathsActedOnLight(grey, regions);
    return BlurActedOnLight(grey(largest.rectangle), largest.estimate.blur);
  }

  /// Grey values from 0 to 1.
  static cv::Mat Unchanged(const cv::Mat& grey) {
    cv::Mat values;
    grey.convertTo(values, CV_32F, 1 / 255.0);
    return values;
  }

  MobifOptions options_;
  SaddleUse saddle_use_ = SaddleUse::kByStrength;
  std::unique_ptr<PsfEstimator> psf_;
  AdaptedSigmaCache adapted_sigma_;  // the same values in whatever order they are asked for
};

}  // namespace

MobifOptions::MobifOptions() {
  wiener.gamma = 0.003;
  wiener.gamma_slope = 0.1;
  wiener.border_passes = 4;
  scale_space.sigma = 1.2;
  hessian.threshold = 2e-4;
  hessian.compact = true;
  hessian.saddles = true;
  hessian.max_anisotropy = 10;
  sift.root = true;
  sift.kind_weight = 0.2;
}

MobifOptions MobifBlobsOptions() {
  MobifOptions options;
  options.hessian.saddles = false;
  return options;
}

MobifOptions MobifFastOptions() {
  MobifOptions options;
  options.wiener.border_passes = 2;
  options.scale_space.sigma = 1.4;
  options.points_per_megapixel = 8000;
  return options;
}

MobifOptions MobifPathOptions() {
  MobifOptions options;
  options.paths = true;
  return options;
}

cv::Ptr<BlurAwareFeature> MakeMobif(const MobifOptions& options) { return cv::makePtr<Mobif>(options); }

}  // namespace gaitcam
