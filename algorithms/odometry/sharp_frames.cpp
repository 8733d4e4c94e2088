#include "algorithms/odometry/sharp_frames.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/median.h"

namespace gaitcam {
namespace {

constexpr size_t kStepFrames = 12;

}  // namespace

bool SharpFrames::Add(double blur) {
  constexpr double kSharpShare = 0.35;
  blurs_.push_back(blur);
  if (blurs_.size() > kStepFrames) blurs_.pop_front();
  const double less = blur - alike_ * std::abs(blur);
  const auto sharper = std::count_if(blurs_.begin(), blurs_.end(), [&](double other) { return other < less; });
  return double(sharper) <= kSharpShare * double(blurs_.size());
}

bool ClearWalk::Add(double detail, bool has_map) {
  constexpr double kClear = 0.74, kBlurred = 0.62;
  details_.push_back(detail);
  if (details_.size() > kStepFrames) details_.pop_front();
  if (!has_map) details_.clear();
  if (details_.size() < kStepFrames) return is_clear_ = false;
  const double most = *std::ranges::max_element(details_);
  const double share = most > 0 ? UpperMedian(std::vector(details_.begin(), details_.end())) / most : 0;
  return is_clear_ = share > kClear || (is_clear_ && share >= kBlurred);
}

double FineDetail(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat smooth, detail;
  grey.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, 1);
  cv::Laplacian(smooth, detail, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(detail, mean, deviation);
  return deviation[0];
}

}  // namespace gaitcam
