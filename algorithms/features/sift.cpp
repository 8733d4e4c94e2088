#include "algorithms/features/sift.h"

#include <algorithm>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

auto SortKey(const cv::KeyPoint& k) { return std::make_tuple(-k.response, k.pt.y, k.pt.x, k.size, k.angle, k.octave); }

}  // namespace

Features DetectSift(const cv::Mat& image, const SiftOptions& options) {
  GAITCAM_ASSERT(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  constexpr int kLayersPerOctave = 3;
  constexpr double kSigma = 1.6;
  const auto sift = cv::SIFT::create(options.max_features, kLayersPerOctave, options.contrast_threshold,
                                     options.edge_threshold, kSigma, CV_32F);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  sift->detectAndCompute(grey, cv::noArray(), keypoints, descriptors);
  // OpenCV keeps ties at the limit and promises no order: choose and order by value.
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return SortKey(keypoints[size_t(a)]) < SortKey(keypoints[size_t(b)]); });
  if (order.size() > size_t(options.max_features)) order.resize(size_t(options.max_features));
  Features features;
  features.descriptors.create(int(order.size()), 128, CV_32FC1);
  for (size_t i = 0; i < order.size(); ++i) {
    features.pixels.push_back(keypoints[size_t(order[i])].pt);
    descriptors.row(order[i]).copyTo(features.descriptors.row(int(i)));
  }
  return features;
}

}  // namespace gaitcam
