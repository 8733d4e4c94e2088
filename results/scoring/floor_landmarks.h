/// How far off a map shows what it shows: corners of the true floor, looked for in the map. An inner part of
/// floor_score.cpp.

#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "results/scoring/floor_score.h"
#include "results/scoring/floor_sheet.h"

namespace gaitcam::internal {

class FloorLandmarkSearch {
 public:
  /// @param sheet outlives this, as do the options. @param map, truth pictures of it, CV_32FC1; `seen` where the map
  /// counts.
  FloorLandmarkSearch(const FloorSheet& sheet, const cv::Mat& map, const cv::Mat& seen, const cv::Mat& truth,
                      const FloorScoreOptions& options);

  /// Corners of the true floor on mapped ground (Shi and Tomasi, CVPR 1994), each with its position in the map.
  std::vector<FloorLandmark> Run() const;

 private:
  std::optional<Eigen::Vector2d> Find(cv::Point at) const;
  double BestElsewhere(const cv::Mat& score, cv::Point best) const;

  const FloorSheet& sheet_;
  const FloorScoreOptions& options_;
  cv::Mat map_, truth_, usable_;
  int half_, search_;
};

}  // namespace gaitcam::internal
