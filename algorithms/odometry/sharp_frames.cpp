#include "algorithms/odometry/sharp_frames.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace gaitcam {

bool SharpFrames::Add(double blur) {
  constexpr size_t kFrames = 12;
  constexpr double kSharpShare = 0.35;
  blurs_.push_back(blur);
  if (blurs_.size() > kFrames) blurs_.pop_front();
  const double less = blur - alike_ * std::abs(blur);
  const auto sharper = std::count_if(blurs_.begin(), blurs_.end(), [&](double other) { return other < less; });
  return double(sharper) <= kSharpShare * double(blurs_.size());
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
