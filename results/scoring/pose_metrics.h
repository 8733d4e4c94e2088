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
  double duration_s = 0, path_length_m = 0;  ///< Between the first and the last pair, along the truth.
  Absolute se3;
  Statistics sim3_m, own_rotation_deg;  ///< The latter after AlignOrientations.
  std::vector<Absolute> also;           ///< For each of ScoreOptions::also_align, yaw before none.
  std::vector<Relative> relative;       ///< Over frames, time and path.
  Drift drift, drift_sim3;
  double scale_ratio = 0;  ///< Length in the estimate over true length; NaN if Sim(3) leaves it free.
  double scale_drift_pct_per_m = 0;
  Turn turn;
};

/// @param scores with pairs, alignments and errors. @pre at least one pair.
PoseMeasures MeasurePoses(const Scores& scores, const Coverage& coverage, const ScoreOptions& options);

/// @param frames_known as Coverage has it: without frames none can be lost.
std::vector<Metric<PoseMeasures>> PoseMetrics(const ScoreOptions& options, bool frames_known);

/// What a run cost on this machine.
struct TimingMeasures {
  std::vector<double> track_ms;  ///< Per frame.
  double peak_memory_mb = 0;
};

/// @param per_frame whether times per frame are known.
std::vector<Metric<TimingMeasures>> TimingMetrics(bool per_frame);

}  // namespace gaitcam
