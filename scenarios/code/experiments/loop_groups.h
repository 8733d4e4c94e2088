/// What memories of places recognise on many walks, summed up over what the walks' scenarios differ in: a table of
/// medians, and a picture.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "results/scoring/loop_recall.h"

namespace gaitcam {

/// One method on one walk.
struct LoopOutcome {
  std::string walk, method;
  int views = 0, accepted = 0, right = 0;
  PrecisionRecall curve;
  double ms_per_view = 0, bytes_per_place = 0;
  double blur_px = 0;               ///< Median over the frames of their median blur.
  std::vector<std::string> levels;  ///< What the walk's scenario says of each key of the summary.
};

/// Values of dotted keys in a recording's resolved scenario. @throws BadInput naming file and key where one has no
/// single number or word, or where the first, which becomes an axis, is no number.
std::vector<std::string> LevelsOf(const std::filesystem::path& scenario, const std::vector<std::string>& keys);

/// Markdown: a row for each method and each combination of levels, medians (lowest to highest) over its walks.
std::string LoopGroupTable(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes);

/// BGR: a column of panels for each method; rows are recall, precision and recall at 100 % precision over the first
/// key; a line for each level of the second, if there is one; bars from the lowest to the highest walk.
/// @pre one or two keys.
cv::Mat DrawLoopGroups(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes);

/// Comma-separated: a line for each outcome.
std::string LoopOutcomeRows(const std::vector<std::string>& keys, const std::vector<LoopOutcome>& outcomes);

}  // namespace gaitcam
