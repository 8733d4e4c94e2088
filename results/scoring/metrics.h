/// Errors of an estimate against the truth, as numbers.
///
/// Absolute (ATE) and relative (RPE) errors follow J. Sturm et al., "A benchmark for the evaluation of RGB-D SLAM
/// systems", IROS 2012, in the conventions of the tool evo, so that figures may be compared with published ones.
/// Everything here works on pairs that are associated already, and aligned where the measure asks for it.

#pragma once

#include <cstdint>
#include <vector>

#include "results/scoring/association.h"
#include "results/scoring/walked_path.h"

namespace gaitcam {

/// Of a list of errors; all NaN for an empty one. `std` divides by n.
struct Statistics {
  size_t count = 0;
  double rmse, mean, median, std, min, max;
};
Statistics Summarize(std::vector<double> values);

/// |p_estimate - p_truth| per pair, m.
std::vector<double> PositionErrors(const std::vector<PosePair>& pairs);
/// Angle of R_estimate^T R_truth per pair, rad in [0, pi].
std::vector<double> RotationErrors(const std::vector<PosePair>& pairs);
std::vector<double> InDegrees(std::vector<double> radians);
/// Frobenius norm of X_estimate^-1 X_truth - I per pair: evo's "full transformation", of mixed unit.
std::vector<double> FullErrors(const std::vector<PosePair>& pairs);

/// How far two poses of a relative error lie apart.
enum class DeltaUnit { kFrames, kSeconds, kMeters };

/// Whose path the metres of an interval are measured along: the walked one, the true camera's with its sway, or the
/// estimate's, as evo has it.
enum class RpePath { kWalked, kTruth, kEstimate };

struct RelativeOptions {
  double delta = 1;  ///< In `unit`; a whole number of pairs for kFrames. Metres are along the path.
  DeltaUnit unit = DeltaUnit::kFrames;
  bool all_pairs = true;  ///< Every pose starts an interval; else each interval starts where the last one ended.
  double tolerance_ratio =
      0.1;  ///< All pairs: the interval may differ from delta by this part of it (not for kFrames).
  RpePath path = RpePath::kWalked;
};

/// What went wrong between two poses: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), Q being truth and P the estimate.
struct RelativeError {
  size_t from = 0, to = 0;   ///< Indices of pairs.
  double translation_m = 0;  ///< |t(E)|
  double rotation_rad = 0;   ///< Angle of R(E), in [0, pi].
};

/// @returns intervals in order of their first index; empty if the run is too short for one.
std::vector<RelativeError> RelativeErrors(const std::vector<PosePair>& pairs, const RelativeOptions& options);

/// Error grown per distance gone, as the KITTI odometry benchmark measures it (A. Geiger et al., CVPR 2012), with
/// lengths that suit the run: over all sub-paths of 10, 20, ..., 80 % of the walked path (WalkedPath), the mean of
/// error over length.
struct Drift {
  double translation_pct;  ///< % of the path; NaN when the truth does not move.
  double rotation_deg_per_m;
  double end_pct;  ///< Error between first and last pose only, % of the path.
};
Drift MeasureDrift(const std::vector<PosePair>& pairs, double sway_window_s = kSwayWindow_s);

/// How the estimate's unit of length changes along the run: slope (Theil-Sen: the median over all slopes) of
/// log(|estimated displacement| / |true displacement|), each over a tenth of the walked path, against the path gone;
/// % per metre. Positive: the estimate grows. NaN when too few sub-paths have a displacement to compare.
double ScaleDriftPctPerM(const std::vector<PosePair>& pairs, double sway_window_s = kSwayWindow_s);

/// Turning about the true vertical, summed over the run without sign: at each step the estimate's rotation since the
/// pose before is seen from the true attitude, so that no alignment of worlds enters. Turning left, then right adds up;
/// the sway of a gait does not, for a change of direction counts only once the true heading has gone back by
/// `hysteresis_deg`. All steps count, those of a system that chose its world anew as well.
struct Turn {
  double true_rad = 0;
  double estimated_rad = 0;  ///< Signed so that turning the same way as the truth is positive.

  /// Estimated over true; above 1 the estimate over-turns. NaN if the truth turned by less than `min_deg`.
  double Gain(double min_deg = 30) const;
};
Turn MeasureTurn(const std::vector<PosePair>& pairs, double hysteresis_deg = 20);

/// The same turning as a course over time: turned about the vertical since the first pair, left positive, rad.
struct TurnCourse {
  std::vector<double> truth, estimate;
};
TurnCourse MeasureTurnCourse(const std::vector<PosePair>& pairs);

/// Largest resident memory of this process so far, MiB; NaN where the system does not tell.
double PeakMemoryMb();

}  // namespace gaitcam
