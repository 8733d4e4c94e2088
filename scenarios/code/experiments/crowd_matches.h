/// Matches between views of a crowd, judged by the truth, and what filters keep of them.

#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "algorithms/features/icgm.h"
#include "scenarios/code/experiments/crowd_views.h"

namespace gaitcam {

/// Putative matches of one pair by one detector. Vectors go by match.
struct JudgedMatches {
  std::string scene, detector;
  bool moving = false;  ///< The camera turned while it exposed.
  uint64_t seed = 0;
  int pair = 0;
  CameraModel camera;
  std::vector<MatchedPosition> matches;
  std::vector<MatchTruth> truth;
  std::vector<double> errors_px;  ///< PairTruth::Error.

  int CountRight() const;
};

/// The strongest 1500. The detector's own threshold is divided by 10 (by 30 for surf, which else finds too little
/// here).
Features FindFeatures(const cv::Mat& image, const std::string& detector);

/// What a detector finds in both views, matched by descriptors alone (mutual, ratio 0.8).
JudgedMatches MatchViews(const CrowdPair& pair, const std::string& detector);

/// Kept matches against the truth.
struct FilterScore {
  int kept = 0, right = 0, near = 0, movers = 0;  ///< near: within 6 px, the right ones among them, none on movers.
  int all_right = 0;                              ///< Before the filter.

  double Precision() const;      ///< NaN where nothing is kept.
  double NearPrecision() const;  ///< The same with 6 px.
  double Recall() const;
  double F1() const;
};
FilterScore ScoreOf(const JudgedMatches& judged, const std::vector<int>& kept);

/// A filter of matches by name.
struct MatchJudge {
  std::string name;
  std::function<std::vector<int>(const JudgedMatches&)> keep;
};

/// By ICGM; fewer than 2 matches keep none. The start is drawn by the pair and `draw`.
std::vector<int> KeepByIcgm(const JudgedMatches& judged, const IcgmOptions& options, int draw = 0);

/// None at all, Hua's ICGM with its threshold, with one of ours and with an automatic one, the consensus with a fixed
/// and an automatic threshold, and for comparison five points and RANSAC with the true calibration.
std::vector<MatchJudge> CrowdFilters();

/// Thresholds from 0.025 to 0.5, ascending, each 1.12 times the one before.
std::vector<double> FixedThresholds();

}  // namespace gaitcam
