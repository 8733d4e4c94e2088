/// The outcome of the feature experiment, as a page to read, as numbers for programs, and as a picture.

#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "scenarios/code/experiments/feature_experiment.h"

namespace gaitcam {

/// Correct matches, factors over OpenCV's SIFT, precision and median error, in Markdown.
/// @param pairs names of the image pairs.
/// @param command that makes the page, to be named on it.
std::string FeatureTable(const std::vector<FeatureCell>& cells, const std::vector<WalkCell>& walk,
                         const std::vector<std::string>& pairs, const std::string& command);

std::string FeatureJson(const std::vector<FeatureCell>& cells, const std::vector<WalkCell>& walk);

/// Correct matches over the extent of the blur, logarithmic, at the first ratio, one image blurred: one panel per
/// setting. CV_8UC3.
cv::Mat FeaturePlot(const std::vector<FeatureCell>& cells);

}  // namespace gaitcam
