#include "algorithms/geometry/ransac.h"

#include "algorithms/core/errors.h"

namespace gaitcam::internal {

std::vector<int> DrawSample(int n, int count, RandomStream& random) {
  GAITCAM_ASSERT(count <= n);
  std::vector<int> sample;
  while (int(sample.size()) < count) {
    const int index = random.Index(n);
    if (std::find(sample.begin(), sample.end(), index) == sample.end()) sample.push_back(index);
  }
  return sample;
}

int SamplesNeeded(double inlier_ratio, int sample_size, double confidence, int max_samples) {
  const double clean = std::pow(inlier_ratio, sample_size);  // probability that a sample has no outlier
  if (clean <= 0) return max_samples;
  if (clean >= 1) return std::min(1, max_samples);
  const double needed = std::log(1 - confidence) / std::log1p(-clean);
  return needed < max_samples ? int(std::ceil(needed)) : max_samples;
}

}  // namespace gaitcam::internal
