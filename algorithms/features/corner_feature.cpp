#include "algorithms/features/corner_feature.h"

#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr float kSize_px = 7;  // a diameter; SIFT describes a square of some six times it, about as much as ORB does

std::vector<cv::KeyPoint> FastCorners(const cv::Mat& grey, double threshold) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(grey, corners, int(threshold), true);
  return corners;
}

std::vector<cv::KeyPoint> HarrisCorners(const cv::Mat& grey, const cv::Mat& mask, double threshold) {
  constexpr int kMaxPoints = 5000;  // callers keep the strongest they want
  constexpr double kDistance_px = 3, kHarris = 0.04;
  constexpr int kBlock_px = 3, kGradient_px = 3;
  std::vector<cv::Point2f> points;
  std::vector<float> responses;
  cv::goodFeaturesToTrack(grey, points, kMaxPoints, threshold, kDistance_px, mask, responses, kBlock_px, kGradient_px,
                          true, kHarris);
  std::vector<cv::KeyPoint> corners;
  for (size_t i = 0; i < points.size(); ++i) corners.emplace_back(points[i], kSize_px, -1.0F, responses[i]);
  return corners;
}

}  // namespace

cv::Ptr<CornerFeature> CornerFeature::create(CornerKind kind, double threshold) {
  GAITCAM_ASSERT(threshold > 0);
  cv::Ptr<CornerFeature> feature = cv::makePtr<CornerFeature>();
  feature->kind_ = kind;
  feature->threshold_ = threshold;
  return feature;
}

std::vector<cv::KeyPoint> CornerFeature::Detect(const cv::Mat& grey, const cv::Mat& mask) const {
  std::vector<cv::KeyPoint> corners =
      kind_ == CornerKind::kFast ? FastCorners(grey, threshold_) : HarrisCorners(grey, mask, threshold_);
  if (!mask.empty()) cv::KeyPointsFilter::runByPixelsMask(corners, mask);
  for (cv::KeyPoint& corner : corners) {
    corner.size = kSize_px;
    corner.angle = 0;  // upright
  }
  return corners;
}

void CornerFeature::detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                                     cv::OutputArray descriptors, bool use_provided_keypoints) {
  cv::Mat grey = image.getMat();
  if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  if (!use_provided_keypoints) keypoints = Detect(grey, mask.getMat());
  if (!descriptors.needed()) return;
  cv::Mat rows(0, descriptorSize(), descriptorType());
  if (!keypoints.empty()) cv::SIFT::create()->compute(grey, keypoints, rows);
  rows.copyTo(descriptors);
}

}  // namespace gaitcam
