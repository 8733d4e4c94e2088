#include "results/scoring/pose_metrics.h"

#include <fmt/format.h>

#include "algorithms/core/units.h"
#include "results/scoring/consistency.h"
#include "results/scoring/jumps.h"
#include "results/scoring/statistics.h"
#include "results/scoring/time_offset.h"

namespace gaitcam {
namespace {

using PoseMetric = Metric<PoseMeasures>;
using TimingMetric = Metric<TimingMeasures>;
using StatisticsOf = std::function<Statistics(const PoseMeasures&)>;

/// An interval of the relative error, as names (`1s`) and sentences ("1 s") have it.
struct RelativeInterval {
  RelativeOptions relative;
  std::string suffix, words;
};

std::vector<RelativeInterval> IntervalsOf(const ScoreOptions& o) {
  RelativeOptions frames{.delta = double(o.rpe_frames), .unit = DeltaUnit::kFrames};
  RelativeOptions seconds{.delta = o.rpe_seconds, .unit = DeltaUnit::kSeconds};
  RelativeOptions meters{.delta = o.rpe_meters, .unit = DeltaUnit::kMeters};
  for (RelativeOptions* relative : {&frames, &seconds, &meters}) {
    relative->all_pairs = o.rpe_pairs == RpePairs::kAll;
    relative->path = o.rpe_path;
  }
  return {
      {frames, fmt::format("{}f", o.rpe_frames), fmt::format("{} frame{}", o.rpe_frames, o.rpe_frames == 1 ? "" : "s")},
      {seconds, fmt::format("{:g}s", o.rpe_seconds), fmt::format("{:g} s", o.rpe_seconds)},
      {meters, fmt::format("{:g}m", o.rpe_meters), fmt::format("{:g} m of path", o.rpe_meters)}};
}

std::vector<Alignment> FurtherAlignments(const ScoreOptions& options) {
  std::vector<Alignment> alignments;
  if (options.also_align == AlsoAlign::kYaw || options.also_align == AlsoAlign::kBoth)
    alignments.push_back(Alignment::kYaw);
  if (options.also_align == AlsoAlign::kNone || options.also_align == AlsoAlign::kBoth)
    alignments.push_back(Alignment::kNone);
  return alignments;
}

// ---- Measures

PoseMeasures::Absolute MeasureAbsolute(const std::vector<PosePair>& pairs, Alignment alignment) {
  const std::vector<PosePair> aligned = Apply(Align(pairs, alignment).X_WV, pairs);
  return {Summarize(PositionErrors(aligned)), Summarize(InDegrees(RotationErrors(aligned)))};
}

/// Rotation does not depend on scale, so it stands once.
PoseMeasures::Relative MeasureRelative(const PoseErrors& errors, const RelativeOptions& interval) {
  std::vector<double> se3_m, sim3_m, rotation_deg;
  for (const RelativeError& e : RelativeErrors(Apply(errors.se3.X_WV, errors.pairs), interval)) {
    se3_m.push_back(e.translation_m);
    rotation_deg.push_back(e.rotation_rad * kDegPerRad);
  }
  for (const RelativeError& e : RelativeErrors(Apply(errors.sim3.X_WV, errors.pairs), interval)) {
    sim3_m.push_back(e.translation_m);
  }
  return {Summarize(se3_m), Summarize(sim3_m), Summarize(rotation_deg)};
}

// ---- Catalogue

std::vector<PoseMetric> CoverageMetrics(bool frames_known) {
  constexpr ScoreGroup kGroup = ScoreGroup::kCoverage;
  std::vector<PoseMetric> metrics = {
      {"coverage_ratio", "", Better::kHigher, kGroup,
       frames_known ? "part of the frames that got a pose with a true one to compare"
                    : "part of the true time span that the estimate covers",
       [](const auto& m) { return m.coverage.ratio; }, true},
      {"frames", "", Better::kNeither, kGroup, frames_known ? "frames given to the system" : "poses in the estimate",
       [](const auto& m) { return double(m.coverage.frames); }},
      {"pairs", "", Better::kHigher, kGroup, "poses compared with the truth",
       [](const auto& m) { return double(m.pairs); }},
      {"tracked_frames", "", Better::kHigher, kGroup, "frames with a pose",
       [](const auto& m) { return double(m.coverage.tracked); }}};
  const std::vector<PoseMetric> of_frames = {
      {"initializing_frames", "", Better::kLower, kGroup, "frames before the first pose",
       [](const auto& m) { return double(m.coverage.initializing); }},
      {"lost_frames", "", Better::kLower, kGroup, "frames without a pose after the first one",
       [](const auto& m) { return double(m.coverage.lost); }},
      {"time_to_first_pose_s", "s", Better::kLower, kGroup, "from the first frame to the first pose",
       [](const auto& m) { return m.coverage.time_to_first_pose_s; }},
      {"inlier_ratio", "", Better::kNeither, kGroup, "inliers over matches, mean over the frames with a pose",
       [](const auto& m) { return m.coverage.inlier_ratio; }}};
  const std::vector<PoseMetric> of_run = {
      {"restarts", "", Better::kNeither, kGroup, "times the system says that it chose its world anew",
       [](const auto& m) { return double(m.coverage.restarts); }},
      {"duration_s", "s", Better::kNeither, kGroup, "from the first compared pose to the last",
       [](const auto& m) { return m.duration_s; }},
      {"path_length_m", "m", Better::kNeither, kGroup, "path walked between them: the true one without the gait's sway",
       [](const auto& m) { return m.path_length_m; }},
      {"camera_path_m", "m", Better::kNeither, kGroup, "path of the true camera between them, sway included",
       [](const auto& m) { return m.camera_path_m; }}};
  if (frames_known) metrics.insert(metrics.end(), of_frames.begin(), of_frames.end());
  metrics.insert(metrics.end(), of_run.begin(), of_run.end());
  return metrics;
}

/// All six statistics of an absolute error, as PREFIX_STATISTIC_UNIT.
void AddStatistics(const std::string& prefix, const std::string& unit, const std::string& what, bool headline,
                   const StatisticsOf& statistics, std::vector<PoseMetric>& metrics) {
  const auto add = [&](const std::string& name, const std::string& words, double Statistics::*value) {
    metrics.push_back({prefix + "_" + name + "_" + unit, unit, Better::kLower, ScoreGroup::kAbsolute,
                       what + ", " + words, [=](const PoseMeasures& m) { return statistics(m).*value; },
                       headline && name == "rmse"});
  };
  add("rmse", "root mean square", &Statistics::rmse);
  add("mean", "mean", &Statistics::mean);
  add("median", "median", &Statistics::median);
  add("std", "standard deviation", &Statistics::std);
  add("min", "smallest", &Statistics::min);
  add("max", "largest", &Statistics::max);
}

void AddAbsolute(const ScoreOptions& options, std::vector<PoseMetric>& metrics) {
  AddStatistics(
      "ate", "m", "position error after SE(3) alignment", true, [](const auto& m) { return m.se3.position_m; },
      metrics);
  AddStatistics(
      "ate_sim3", "m", "position error after Sim(3) alignment", true, [](const auto& m) { return m.sim3_m; }, metrics);
  AddStatistics(
      "ate_rot", "deg", "rotation error after SE(3) alignment", false, [](const auto& m) { return m.se3.rotation_deg; },
      metrics);
  AddStatistics(
      "ate_rot_own", "deg", "rotation error after the rotation that fits orientations best", true,
      [](const auto& m) { return m.own_rotation_deg; }, metrics);
  const std::vector<Alignment> alignments = FurtherAlignments(options);
  for (size_t k = 0; k < alignments.size(); ++k) {
    const std::string name = "ate_" + ToString(alignments[k]);
    const std::string what =
        alignments[k] == Alignment::kYaw ? "after yaw and position alignment" : "without alignment";
    AddStatistics(
        name, "m", "position error " + what, false, [=](const auto& m) { return m.also[k].position_m; }, metrics);
    AddStatistics(
        name + "_rot", "deg", "rotation error " + what, false, [=](const auto& m) { return m.also[k].rotation_deg; },
        metrics);
  }
}

/// Root mean square and median of each relative error.
void AddRelative(const ScoreOptions& options, std::vector<PoseMetric>& metrics) {
  const std::vector<RelativeInterval> intervals = IntervalsOf(options);
  for (size_t k = 0; k < intervals.size(); ++k) {
    const auto add = [&](const std::string& measure, const std::string& unit, const std::string& what,
                         const std::string& correction, Statistics PoseMeasures::Relative::*error) {
      const auto row = [&](const std::string& name, const std::string& words, double Statistics::*value) {
        metrics.push_back({measure + "_" + name + "_" + unit + "_" + intervals[k].suffix, unit, Better::kLower,
                           ScoreGroup::kRelative,
                           "drift in " + what + " over " + intervals[k].words + correction + ", " + words,
                           [=](const PoseMeasures& m) { return (m.relative[k].*error).*value; }});
      };
      row("rmse", "root mean square", &Statistics::rmse);
      row("median", "median", &Statistics::median);
    };
    add("rpe_trans", "m", "position", "", &PoseMeasures::Relative::se3_m);
    add("rpe_rot", "deg", "rotation", "", &PoseMeasures::Relative::rotation_deg);
    add("rpe_sim3_trans", "m", "position", ", scale corrected", &PoseMeasures::Relative::sim3_m);
  }
}

std::vector<PoseMetric> DriftMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kDrift;
  return {{"drift_pct", "%", Better::kLower, kGroup,
           "mean error over length walked, of sub-paths of 10 to 80 % of the path",
           [](const auto& m) { return m.drift.translation_pct; }},
          {"drift_sim3_pct", "%", Better::kLower, kGroup, "drift of the scale-corrected estimate",
           [](const auto& m) { return m.drift_sim3.translation_pct; }, true},
          {"drift_rot_deg_per_m", "deg/m", Better::kLower, kGroup, "rotation error per length over the same sub-paths",
           [](const auto& m) { return m.drift.rotation_deg_per_m; }},
          {"end_drift_pct", "%", Better::kLower, kGroup, "error between first and last pose, part of the path walked",
           [](const auto& m) { return m.drift.end_pct; }},
          {"end_drift_sim3_pct", "%", Better::kLower, kGroup, "error at the end, scale corrected",
           [](const auto& m) { return m.drift_sim3.end_pct; }}};
}

std::vector<PoseMetric> ScaleAndTurnMetrics() {
  return {{"scale_ratio", "", Better::kNearOne, ScoreGroup::kScale,
           "length in the estimate over true length, by Sim(3) alignment", [](const auto& m) { return m.scale_ratio; },
           true},
          {"scale_error_pct", "%", Better::kNearZero, ScoreGroup::kScale, "how much too long the estimate is",
           [](const auto& m) { return 100 * (m.scale_ratio - 1); }},
          {"scale_drift_pct_per_m", "%/m", Better::kNearZero, ScoreGroup::kScale,
           "growth of the estimate's scale along the path", [](const auto& m) { return m.scale_drift_pct_per_m; }},
          {"turn_true_deg", "deg", Better::kNeither, ScoreGroup::kRotation,
           "total true turn about the vertical, left plus right",
           [](const auto& m) { return m.turn.true_rad * kDegPerRad; }},
          {"turn_estimated_deg", "deg", Better::kNeither, ScoreGroup::kRotation, "total estimated turn",
           [](const auto& m) { return m.turn.estimated_rad * kDegPerRad; }},
          {"rotation_gain", "", Better::kNearOne, ScoreGroup::kRotation,
           "estimated over true total turn; above 1 it over-turns", [](const auto& m) { return m.turn.Gain(); }, true}};
}

std::vector<PoseMetric> JumpMetrics() {
  constexpr ScoreGroup kGroup = ScoreGroup::kJumps;
  const JumpRule rule;
  return {{"jumps", "", Better::kLower, kGroup,
           fmt::format("steps between successive poses that are wrong by more than {:g} cm or {:g} deg, plus {:g} % of "
                       "the true step",
                       100 * rule.position_m, rule.rotation_deg, 100 * rule.share),
           [](const auto& m) { return double(m.jumps); }, true},
          {"largest_jump_m", "m", Better::kLower, kGroup, "the largest of them, scale corrected",
           [](const auto& m) { return m.largest_jump_m; }},
          {"time_offset_ms", "ms", Better::kNearZero, kGroup, "by how much the poses' stamps are late",
           [](const auto& m) { return m.time_offset_ms; }}};
}

std::vector<PoseMetric> ConsistencyMetrics(const ScoreOptions& options) {
  constexpr ScoreGroup kGroup = ScoreGroup::kConsistency;
  const std::string interval = fmt::format("{:g} s", options.rpe_seconds);
  const std::string suffix = fmt::format("_{:g}s", options.rpe_seconds);
  return {{"nees", "", Better::kNearOne, kGroup,
           "squared error of a pose over its stated covariance, mean per dimension; above 1 it is overconfident",
           [](const auto& m) { return m.nees; }, true},
          {"nees_in_band_ratio", "", Better::kNeither, kGroup, "part of the poses within its 95 % band",
           [](const auto& m) { return m.nees_in_band; }},
          {"nees" + suffix, "", Better::kNearOne, kGroup, "the same of the motion over " + interval,
           [](const auto& m) { return m.nees_relative; }, true},
          {"nees_in_band_ratio" + suffix, "", Better::kNeither, kGroup, "part of these motions within the band",
           [](const auto& m) { return m.nees_relative_in_band; }},
          {"nees_1f", "", Better::kNearOne, kGroup, "the same of the motion from frame to frame",
           [](const auto& m) { return m.nees_frame; }, true},
          {"nees_in_band_ratio_1f", "", Better::kNeither, kGroup, "part of these motions within the band",
           [](const auto& m) { return m.nees_frame_in_band; }}};
}

/// Only of the frames and the truth: the same for both answers.
bool IsOfTheWalk(const std::string& name) {
  for (const char* of_walk : {"frames", "duration_s", "path_length_m", "camera_path_m", "turn_true_deg"}) {
    if (name == of_walk) return true;
  }
  return false;
}

void MeasureUncertainty(const PoseErrors& errors, const ScoreOptions& options, PoseMeasures& m) {
  const std::vector<NeesSample> absolute = AbsoluteNees(errors.pairs);
  const std::vector<NeesSample> relative = RelativeNees(errors.pairs, options.rpe_seconds);
  m.nees = MeanNees(absolute);
  m.nees_in_band = ShareInBand(absolute);
  m.nees_relative = MeanNees(relative);
  m.nees_relative_in_band = ShareInBand(relative);
  const std::vector<NeesSample> per_frame = FrameNees(errors.pairs);
  m.nees_frame = MeanNees(per_frame);
  m.nees_frame_in_band = ShareInBand(per_frame);
}

}  // namespace

PoseMeasures MeasurePoses(const PoseErrors& s, const Trajectory& truth, const Coverage& coverage,
                          const ScoreOptions& options) {
  PoseMeasures m;
  m.coverage = coverage;
  m.pairs = s.pairs.size();
  m.duration_s = SecondsBetween(s.pairs.front().stamp_ns, s.pairs.back().stamp_ns);
  m.path_length_m = WalkedPath(s.pairs).back();
  m.camera_path_m = WalkedPath(s.pairs, 0).back();
  m.se3 = {Summarize(s.error_se3_m), Summarize(s.error_rot_deg)};
  m.sim3_m = Summarize(s.error_sim3_m);
  m.own_rotation_deg = Summarize(s.error_rot_own_deg);
  for (const Alignment alignment : FurtherAlignments(options)) m.also.push_back(MeasureAbsolute(s.pairs, alignment));
  for (const RelativeInterval& interval : IntervalsOf(options)) {
    m.relative.push_back(MeasureRelative(s, interval.relative));
  }
  m.drift = MeasureDrift(Apply(s.se3.X_WV, s.pairs));
  m.drift_sim3 = MeasureDrift(Apply(s.sim3.X_WV, s.pairs));
  m.scale_ratio = s.sim3.scale_known ? 1 / s.sim3.X_WV.scale : kNaN;
  m.scale_drift_pct_per_m = ScaleDriftPctPerM(s.pairs);
  m.turn = MeasureTurn(s.pairs);
  const std::vector<Jump> jumps = FindJumps(Apply(s.sim3.X_WV, s.pairs));
  m.jumps = jumps.size();
  for (const Jump& jump : jumps) m.largest_jump_m = std::max(m.largest_jump_m, jump.position_m);
  m.time_offset_ms = EstimateTimeOffsetMs(s.pairs, truth);
  MeasureUncertainty(s, options, m);
  return m;
}

PoseMeasures MeasureCoverageAlone(const Coverage& coverage, size_t pairs, const ScoreOptions& options) {
  const Statistics none = Summarize({});
  PoseMeasures m;
  m.coverage = coverage;
  m.pairs = pairs;
  m.duration_s = m.path_length_m = m.camera_path_m = kNaN;
  m.se3 = {none, none};
  m.sim3_m = m.own_rotation_deg = none;
  m.also.assign(FurtherAlignments(options).size(), {none, none});
  m.relative.assign(IntervalsOf(options).size(), {none, none, none});
  m.drift = m.drift_sim3 = {kNaN, kNaN, kNaN};
  m.scale_ratio = m.scale_drift_pct_per_m = m.largest_jump_m = m.time_offset_ms = kNaN;
  m.nees = m.nees_in_band = m.nees_relative = m.nees_relative_in_band = m.nees_frame = m.nees_frame_in_band = kNaN;
  m.turn = {kNaN, kNaN};
  return m;
}

std::vector<PoseMetric> PoseMetrics(const ScoreOptions& options, bool frames_known) {
  std::vector<PoseMetric> metrics = CoverageMetrics(frames_known);
  AddAbsolute(options, metrics);
  AddRelative(options, metrics);
  for (const std::vector<PoseMetric>& more :
       {DriftMetrics(), ScaleAndTurnMetrics(), JumpMetrics(), ConsistencyMetrics(options)}) {
    metrics.insert(metrics.end(), more.begin(), more.end());
  }
  return metrics;
}

std::vector<PoseMetric> LivePoseMetrics(const ScoreOptions& options) {
  std::vector<PoseMetric> metrics = PoseMetrics(options, true);
  std::erase_if(metrics, [](const PoseMetric& metric) { return IsOfTheWalk(metric.name); });
  for (PoseMetric& metric : metrics) {
    metric.name = "live_" + metric.name;
    metric.meaning = "live: " + metric.meaning;
  }
  return metrics;
}

std::vector<TimingMetric> TimingMetrics(bool per_frame) {
  constexpr ScoreGroup kGroup = ScoreGroup::kTiming;
  std::vector<TimingMetric> metrics;
  if (per_frame) {
    metrics = {{"track_ms_mean", "ms", Better::kLower, kGroup, "tracking time per frame, mean",
                [](const auto& m) { return Summarize(m.track_ms).mean; }, true},
               {"track_ms_p95", "ms", Better::kLower, kGroup, "tracking time per frame, 95th percentile",
                [](const auto& m) { return QuantileOf(m.track_ms, 0.95); }},
               {"track_ms_max", "ms", Better::kLower, kGroup, "tracking time per frame, largest",
                [](const auto& m) { return Summarize(m.track_ms).max; }}};
  }
  metrics.push_back({"peak_memory_mb", "MiB", Better::kLower, kGroup, "largest resident memory of the process so far",
                     [](const auto& m) { return m.peak_memory_mb; }});
  return metrics;
}

}  // namespace gaitcam
