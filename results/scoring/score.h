/// The scores of a run: one ordered list of named numbers, and what plots need beside them.
///
/// Which there are is a catalogue of metrics (pose_metrics.h). Accuracy stands under SE(3) (the estimate's own scale)
/// and under Sim(3) (scale given away, as monocular systems need) always. One alignment serves the whole run: a system
/// that restarted in the middle is not forgiven the jump. Coverage comes first; an estimate that covers too little has
/// no scores at all.
///
/// Both answers of a system are scored: what it finally said of each frame, and what it said live, when it had seen
/// nothing later. Names that begin with "live_" are of the latter; all others of poses are of the final answer.

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/estimate.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/trajectory.h"
#include "results/scoring/alignment.h"
#include "results/scoring/association.h"
#include "results/scoring/metric.h"
#include "results/scoring/metrics.h"
#include "results/scoring/place_graph_score.h"

namespace gaitcam {

/// Whether every pose starts an interval of the relative error, or one interval follows the other.
enum class RpePairs { kAll, kConsecutive };
constexpr auto WordsOf(RpePairs) {
  return std::array{EnumWord{RpePairs::kAll, "all"}, EnumWord{RpePairs::kConsecutive, "consecutive"}};
}

constexpr auto WordsOf(RpePath) {
  return std::array{EnumWord{RpePath::kWalked, "walked"}, EnumWord{RpePath::kTruth, "truth"},
                    EnumWord{RpePath::kEstimate, "estimate"}};
}

/// Alignments of the absolute error beside SE(3) and Sim(3).
enum class AlsoAlign { kNoMore, kNone, kYaw, kBoth };
constexpr auto WordsOf(AlsoAlign) {
  return std::array{EnumWord{AlsoAlign::kNoMore, ""}, EnumWord{AlsoAlign::kNone, "none"},
                    EnumWord{AlsoAlign::kYaw, "yaw"}, EnumWord{AlsoAlign::kBoth, "both"}};
}

struct ScoreOptions {
  using DescribedTag = void;

  AssociationOptions association;
  int min_pairs = 10;
  double min_coverage_ratio = 0.1;
  int rpe_frames = 1;
  double rpe_seconds = 1.0;
  double rpe_meters = 1.0;
  RpePairs rpe_pairs = RpePairs::kAll;
  RpePath rpe_path = RpePath::kWalked;
  AlsoAlign also_align =
      AlsoAlign::kNoMore;  ///< Further alignments of the absolute error: "none", "yaw", "both" or "".
  std::optional<PlaceGraphScoreOptions> places;
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
  visit("rpe_pairs", o.rpe_pairs, EnumWords<RpePairs>(),
        "whether every pose starts an interval of the relative error, or one interval follows the other");
  visit("rpe_path", o.rpe_path, EnumWords<RpePath>(),
        "whose path metres are measured along: the walked one without the gait's sway, the camera's, the estimate's");
  visit("also_align", o.also_align, EnumWords<AlsoAlign>(),
        "further alignments of the absolute error, beside SE(3) and Sim(3)");
  visit("places", o.places, Nested(), "when a loop of a topological map is right; absent: as a robot's in a room");
}

/// The errors of one of the two answers.
struct PoseErrors {
  std::vector<PosePair> pairs;  ///< As associated, not aligned.
  AlignmentResult se3, sim3;
  Trajectory aligned_se3, aligned_sim3;  ///< All poses of the answer, X_WC, in the world of the truth.
  std::vector<double> error_se3_m, error_sim3_m, error_rot_deg;  ///< Per pair.
  std::vector<double> error_rot_own_deg;  ///< Per pair, after the rotation that fits the orientations best.
};

struct Scores {
  std::vector<Score> scores;         ///< In the order of a table; equal from run to run of the same input.
  std::vector<Score> timing;         ///< Wall time and memory: differ from run to run.
  std::vector<std::string> remarks;  ///< What a reader should know before believing a number.

  PoseErrors last;                 ///< Of the final answer.
  std::optional<PoseErrors> live;  ///< Of the live one; nothing if there was none, or too little to align.

  /// Whether there were poses to score; a topological map has none.
  bool HasPoses() const { return !last.pairs.empty(); }
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

}  // namespace gaitcam
