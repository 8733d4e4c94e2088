#include "algorithms/features/psf_oracle.h"

#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

LineBlur MeanBlur(const cv::Mat& vectors) {
  GAITCAM_ASSERT(vectors.empty() || vectors.type() == CV_32FC2);
  // A direction and its opposite are the same: double the angle, so that they add up.
  double length = 0, c2 = 0, s2 = 0;
  int count = 0;
  for (int y = 0; y < vectors.rows; ++y) {
    const cv::Vec2f* row = vectors.ptr<cv::Vec2f>(y);
    for (int x = 0; x < vectors.cols; ++x) {
      const double u = row[x][0], v = row[x][1];
      if (!std::isfinite(u) || !std::isfinite(v)) continue;
      length += std::hypot(u, v);
      c2 += u * u - v * v;
      s2 += 2 * u * v;
      ++count;
    }
  }
  if (count == 0) return {};
  const double angle = 0.5 * std::atan2(s2, c2);
  return {length / count, angle < 0 ? angle + M_PI : angle};
}

OraclePsf::OraclePsf(const LineBlur& blur, double verdict_px) : blur_(blur), verdict_px_(verdict_px) {}

OraclePsf::OraclePsf(const cv::Mat& vectors, double verdict_px) : vectors_(vectors), verdict_px_(verdict_px) {
  GAITCAM_ASSERT(!vectors.empty() && vectors.type() == CV_32FC2);
}

BlurEstimate OraclePsf::Estimate(const cv::Mat& grey, const cv::Rect& region) const {
  BlurEstimate estimate;
  estimate.blur = blur_;
  estimate.confidence = 1;
  if (!vectors_.empty()) {
    GAITCAM_ASSERT(vectors_.size() == grey.size());
    const cv::Rect seen = region & cv::Rect({0, 0}, grey.size());
    estimate.blur = seen.area() > 0 ? MeanBlur(vectors_(seen)) : LineBlur();
  }
  estimate.blurred = estimate.blur.extent_px >= verdict_px_;
  return estimate;
}

}  // namespace gaitcam
