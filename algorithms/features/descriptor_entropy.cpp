#include "algorithms/features/descriptor_entropy.h"

#include <cmath>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {

std::vector<double> DescriptorEntropies(const cv::Mat& descriptors) {
  GAITCAM_ASSERT(descriptors.empty() || descriptors.type() == CV_32FC1);
  std::vector<double> entropies;
  for (int i = 0; i < descriptors.rows; ++i) {
    const float* s = descriptors.ptr<float>(i);
    double sum = 0, entropy = 0;
    for (int k = 0; k < descriptors.cols; ++k) sum += s[k];
    for (int k = 0; k < descriptors.cols; ++k)
      if (s[k] > 0) entropy -= s[k] / sum * std::log(s[k] / sum);  // equation 5.18
    entropies.push_back(entropy);
  }
  return entropies;
}

Features DiscardLowEntropy(const Features& features) {
  const std::vector<double> entropies = DescriptorEntropies(features.descriptors);
  double sum = 0, squares = 0;
  for (const double h : entropies) {
    sum += h;
    squares += h * h;
  }
  const double n = std::max(1.0, double(entropies.size())), mean = sum / n;
  const double limit = mean - std::sqrt(std::max(squares / n - mean * mean, 0.0));
  Features kept;
  kept.descriptors = cv::Mat(0, features.descriptors.cols, CV_32FC1);
  for (int i = 0; i < features.size(); ++i) {
    if (entropies[size_t(i)] < limit) continue;
    kept.keypoints.push_back(features.keypoints[size_t(i)]);
    kept.descriptors.push_back(features.descriptors.row(i));
  }
  return kept;
}

}  // namespace gaitcam
