/// The metrics of a trajectory, and what they are computed from.
///
/// Names read as in a table: measure, alignment if it is not SE(3), statistic, unit, interval: `ate_rmse_m`,
/// `ate_sim3_rmse_m`, `rpe_trans_rmse_m_1s`. Names and texts depend on the intervals and alignments of ScoreOptions.

#pragma once

#include <vector>

#include "results/scoring/coverage.h"
#include "results/scoring/metric.h"
#include "results/scoring/metrics.h"
#include "results/scoring/score.h"

namespace gaitcam {

/// What the metrics of a trajectory take their values from.
struct PoseMeasures {
  struct Absolute {
    Statistics position_m, rotation_deg;
  };
  struct Relative {
    Statistics se3_m, sim3_m, rotation_deg;
  };

  Coverage coverage;
  size_t pairs = 0;
  double duration_s = 0;                        ///< Between the first and the last pair.
  double path_length_m = 0, camera_path_m = 0;  ///< Walked (WalkedPath), and along the true camera's path.
  Absolute se3;
  Statistics sim3_m, own_rotation_deg;  ///< The latter after AlignOrientations.
  std::vector<Absolute> also;           ///< For each of ScoreOptions::also_align, yaw before none.
  std::vector<Relative> relative;       ///< Over frames, time and path.
  Drift drift, drift_sim3;
  double scale_ratio = 0;  ///< Length in the estimate over true length; NaN if Sim(3) leaves it free.
  double scale_drift_pct_per_m = 0;
  Turn turn;
  size_t jumps = 0;                                                                 ///< FindJumps, under Sim(3).
  double largest_jump_m = 0;                                                        ///< 0 without one.
  double time_offset_ms = 0;                                                        ///< EstimateTimeOffsetMs.
  double nees = 0, nees_in_band = 0, nees_relative = 0, nees_relative_in_band = 0;  ///< NaN without covariances,
  double nees_frame = 0, nees_frame_in_band = 0;                                    ///< likewise.
};

/// @pre at least one pair.
PoseMeasures MeasurePoses(const PoseErrors& errors, const Trajectory& truth, const Coverage& coverage,
                          const ScoreOptions& options);
/// Of an answer too short to have errors: coverage alone, all else NaN.
PoseMeasures MeasureCoverageAlone(const Coverage& coverage, size_t pairs, const ScoreOptions& options);

/// Of the final answer. @param frames_known as Coverage has it: without frames none can be lost.
std::vector<Metric<PoseMeasures>> PoseMetrics(const ScoreOptions& options, bool frames_known);

/// Of the live answer: the same, named "live_...", without what does not depend on the answer.
std::vector<Metric<PoseMeasures>> LivePoseMetrics(const ScoreOptions& options);

/// What a run cost on this machine.
struct TimingMeasures {
  std::vector<double> track_ms;  ///< Per frame.
  double peak_memory_mb = 0;
};

/// @param per_frame whether times per frame are known.
std::vector<Metric<TimingMeasures>> TimingMetrics(bool per_frame);

}  // namespace gaitcam
