/// Pictures of the crowds experiment.

#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "scenarios/code/experiments/crowd_matches.h"

namespace gaitcam {

/// One line over 1 / threshold.
struct ThresholdCurve {
  std::string label;
  cv::Scalar bgr;
  std::vector<double> values;  ///< By threshold; NaN where there is none.
};

/// A panel over 1 / threshold, linear from 0 to `most` upwards.
struct ThresholdPanel {
  std::string title;
  double most = 1;
  std::vector<ThresholdCurve> curves;
};

/// Panels side by side, BGR. @param thresholds ascending.
cv::Mat DrawThresholds(const std::vector<double>& thresholds, const std::vector<ThresholdPanel>& panels);

/// Both views side by side: key points of what is kept are green, joined by lines for some of them; of what is dropped
/// red. Greys are coarse, to keep the file small.
cv::Mat DrawMatches(const cv::Mat& a, const cv::Mat& b, const std::vector<MatchedPosition>& matches,
                    const std::vector<int>& kept);

}  // namespace gaitcam
