/// The scores of a run: one ordered list of named numbers, and what plots need beside them.
///
/// Names read as in a table: measure, alignment if it is not SE(3), statistic, unit, interval: `ate_rmse_m`,
/// `ate_sim3_rmse_m`, `rpe_trans_rmse_m_1s`. Accuracy stands under SE(3) (the estimate's own scale) and under Sim(3)
/// (scale given away, as monocular systems need) always. One alignment serves the whole run: a system that started anew
/// in the middle is not forgiven the jump. Coverage comes first; an estimate that covers too little has no scores at
/// all.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/trajectory.h"
#include "results/alignment.h"
#include "results/association.h"

namespace gaitcam {

struct ScoreOptions {
  using DescribedTag = void;

  AssociationOptions association;
  int min_pairs = 10;               ///< Fewer associated pairs than this: no scores.
  double min_coverage_ratio = 0.1;  ///< A smaller part of the frames with a pose: no scores.
  int rpe_frames = 1;               ///< Interval of the relative error over frames.
  double rpe_seconds = 1.0;         ///< Interval over time, s.
  double rpe_meters = 1.0;          ///< Interval along the path, m.
  std::string rpe_pairs = "all";    ///< "all": every pose starts an interval; "consecutive": one after the other.
  std::string rpe_path = "truth";   ///< Whose path the metres are measured along; evo takes "estimate".
  std::string also_align;           ///< Further alignments of the absolute error: "none", "yaw", "both" or "".
};

template <class Visitor>
void VisitFields(Visitor& visit, ScoreOptions& o) {
  visit("association", o.association, Nested(), "which poses belong together");
  visit("min_pairs", o.min_pairs, Between(3, 1e9), "fewer pairs than this are not scored");
  visit("min_coverage_ratio", o.min_coverage_ratio, Between(0.0, 1.0),
        "a smaller part of frames with a pose is not scored");
  visit("rpe_frames", o.rpe_frames, Between(1, 1e6), "interval of the relative error, frames");
  visit("rpe_seconds", o.rpe_seconds, Between(1e-3, 1e5), "interval of the relative error, s");
  visit("rpe_meters", o.rpe_meters, Between(1e-3, 1e5), "interval of the relative error along the path, m");
  visit("rpe_pairs", o.rpe_pairs, OneOf({"all", "consecutive"}), "whether intervals overlap");
  visit("rpe_path", o.rpe_path, OneOf({"truth", "estimate"}), "whose path metres are measured along");
  visit("also_align", o.also_align, OneOf({"", "none", "yaw", "both"}), "further alignments of the absolute error");
}

/// Which way a score gets better.
enum class Better { kLower, kHigher, kNearOne, kNearZero, kNeither };

struct Score {
  std::string name;
  double value = 0;     ///< NaN where the run does not determine it (null in JSON, "-" in tables).
  std::string unit;     ///< "" for ratios and counts.
  std::string meaning;  ///< One line.
  Better better = Better::kNeither;
};

struct Scores {
  std::vector<Score> scores;         ///< In the order of a table; equal from run to run of the same input.
  std::vector<Score> timing;         ///< Wall time and memory: differ from run to run.
  std::vector<std::string> remarks;  ///< What a reader should know before believing a number.

  std::vector<PosePair> pairs;  ///< As associated, not aligned.
  AlignmentResult se3, sim3;
  Trajectory aligned_se3, aligned_sim3;  ///< All poses of the estimate, X_WC, in the world of the truth.
  std::vector<double> error_se3_m, error_sim3_m, error_rot_deg;  ///< Per pair.
  std::vector<double> error_rot_own_deg;  ///< Per pair, after the rotation that fits the orientations best.

  /// Whether there were poses to score; a topological map has none.
  bool HasPoses() const { return !pairs.empty(); }
  /// @returns the value of a score or timing by name. @throws BadInput naming the nearest known one.
  double Value(const std::string& name) const;
};

/// Scores an estimate. `frame_stamps` are all frames that the system was given, in order; empty if that is not known
/// (two files are compared): then coverage is the part of the true time span over which the estimate has no gap (longer
/// than 2.5 of its usual intervals) and there are no lost frames to count.
/// @throws BadInput for stamps that do not increase; BadOption; TooLittleData if too few pairs or too little coverage.
Scores ScoreEstimate(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                     const ScoreOptions& options);

/// What there is to say of a system that gives no poses: how many frames it saw, and how long that took.
Scores ScoreWithoutPoses(const Estimate& estimate);

/// An estimate that is a bare trajectory, from a file.
Estimate EstimateFromTrajectory(const Trajectory& trajectory);

/// scores.json: schema version, scores, remarks, alignments; and timing in an object of its own, so that all the rest
/// is byte-identical from run to run. Ends with a line feed.
std::string ScoresToJson(const Scores& scores);

/// Aligned columns for a terminal: name, value, unit, meaning.
std::string ScoresToTable(const Scores& scores);

/// A value as a table shows it: four significant digits, counts in full, "-" for NaN.
std::string ScoreText(double value);

}  // namespace gaitcam
