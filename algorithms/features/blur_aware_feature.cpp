#include "algorithms/features/blur_aware_feature.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Larger than any image; cut to the image's size when that is known.
const cv::Rect kWholeImage(0, 0, 1 << 20, 1 << 20);

Features Masked(const Features& features, const cv::Mat& mask) {
  Features kept;
  kept.descriptors = cv::Mat(0, features.descriptors.cols, features.descriptors.type());
  for (int i = 0; i < features.size(); ++i) {
    const cv::Point2f& p = features.keypoints[size_t(i)].pt;
    const cv::Point pixel(cvRound(p.x), cvRound(p.y));
    if (!cv::Rect({0, 0}, mask.size()).contains(pixel) || mask.at<uchar>(pixel) == 0) continue;
    kept.keypoints.push_back(features.keypoints[size_t(i)]);
    kept.descriptors.push_back(features.descriptors.row(i));
  }
  return kept;
}

}  // namespace

void BlurAwareFeature::SetMinBlur(double) { throw BadOption("min_blur_px: this detector has no such limit"); }

void BlurAwareFeature::SetBlur(const std::optional<LineBlur>& blur) {
  known_.clear();
  if (blur) known_.push_back({kWholeImage, {*blur, 1, blur->extent_px > 0}});
}

std::vector<BlurRegion> BlurAwareFeature::KnownRegions(const cv::Size& image) const {
  std::vector<BlurRegion> regions = known_;
  for (BlurRegion& region : regions) region.rectangle &= cv::Rect({0, 0}, image);
  return regions;
}

void BlurAwareFeature::detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                                        cv::OutputArray descriptors, bool use_provided_keypoints) {
  CV_Assert(!use_provided_keypoints);
  cv::Mat grey = image.getMat();
  CV_Assert(grey.empty() || grey.type() == CV_8UC1 || grey.type() == CV_8UC3);
  if (grey.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  Features features;
  if (!grey.empty()) features = Extract(grey, kAllFeatures);
  if (!mask.empty()) features = Masked(features, mask.getMat());
  keypoints = std::move(features.keypoints);
  if (descriptors.needed()) {
    if (keypoints.empty()) features.descriptors = cv::Mat(0, descriptorSize(), CV_32FC1);
    features.descriptors.copyTo(descriptors);
  }
}

void BlurAwareFeature::detect(cv::InputArray image, std::vector<cv::KeyPoint>& keypoints, cv::InputArray mask) {
  detectAndCompute(image, mask, keypoints, cv::noArray(), false);
}

}  // namespace gaitcam
