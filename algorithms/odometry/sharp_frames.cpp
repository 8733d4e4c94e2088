#include "algorithms/odometry/sharp_frames.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
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

bool ClearWalk::Add(int64_t stamp_ns, double detail, bool has_map) {
  constexpr int64_t kWindow_ns = 1'100'000'000;  // twelve frames at 10 frames/s, some three steps
  constexpr size_t kFewest = 6;
  constexpr double kClear = 0.74, kBlurred = 0.62;
  if (!has_map) {
    frames_.clear();
    map_since_ns_.reset();
    return is_clear_ = false;
  }
  if (!map_since_ns_) map_since_ns_ = stamp_ns;
  frames_.push_back({stamp_ns, detail});
  while (stamp_ns - frames_.front().stamp_ns > kWindow_ns) frames_.pop_front();
  if (stamp_ns - *map_since_ns_ < kWindow_ns || frames_.size() < kFewest) return is_clear_ = false;
  std::vector<double> details;
  for (const Frame& frame : frames_) details.push_back(frame.detail);
  const double most = *std::ranges::max_element(details);
  const double share = most > 0 ? UpperMedian(std::move(details)) / most : 0;
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
