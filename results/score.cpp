#include "results/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "algorithms/core/errors.h"
#include "results/metrics.h"
#include "results/statistics.h"

namespace gaitcam {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegrees = 180 / std::numbers::pi;

double SecondsBetween(int64_t from_ns, int64_t to_ns) { return double(to_ns - from_ns) * 1e-9; }

std::vector<double> InDegrees(std::vector<double> radians) {
  for (double& v : radians) v *= kDegrees;
  return radians;
}

/// Adds scores to a list.
class Table {
 public:
  explicit Table(std::vector<Score>& rows) : rows_(rows) {}

  void Add(std::string name, double value, std::string unit, std::string meaning, Better better) {
    rows_.push_back({std::move(name), value, std::move(unit), std::move(meaning), better});
  }
  /// All six statistics of an error, as PREFIX_STATISTIC_UNIT.
  void AddStatistics(const std::string& prefix, const std::vector<double>& errors, const std::string& unit,
                     const std::string& what) {
    const Statistics s = Summarize(errors);
    Add(prefix + "_rmse_" + unit, s.rmse, unit, what + ", root mean square", Better::kLower);
    Add(prefix + "_mean_" + unit, s.mean, unit, what + ", mean", Better::kLower);
    Add(prefix + "_median_" + unit, s.median, unit, what + ", median", Better::kLower);
    Add(prefix + "_std_" + unit, s.std, unit, what + ", standard deviation", Better::kLower);
    Add(prefix + "_min_" + unit, s.min, unit, what + ", smallest", Better::kLower);
    Add(prefix + "_max_" + unit, s.max, unit, what + ", largest", Better::kLower);
  }

 private:
  std::vector<Score>& rows_;
};

/// What part of the true time span the estimate covers, when nothing is known of frames: gaps longer than 2.5 usual
/// intervals are not covered.
double TimeCoverage(const std::vector<PosePair>& pairs, const Trajectory& truth) {
  std::vector<double> gaps;
  for (size_t i = 1; i < pairs.size(); ++i) gaps.push_back(SecondsBetween(pairs[i - 1].stamp_ns, pairs[i].stamp_ns));
  const double longest = 2.5 * MedianOf(gaps);
  double covered = 0;
  for (const double gap : gaps) covered += gap <= longest ? gap : 0;
  const double span = truth.size() < 2 ? 0 : SecondsBetween(truth.front().stamp_ns, truth.back().stamp_ns);
  return span > 0 ? covered / span : 0;
}

/// How much of the run has a pose.
struct Coverage {
  double ratio = 0, time_to_first_pose_s = kNaN;
  size_t frames = 0, tracked = 0, initializing = 0, lost = 0, restarts = 0;
  bool frames_known = false;
};

Coverage MeasureCoverage(const Estimate& estimate, const Trajectory& truth, const std::vector<PosePair>& pairs,
                         const std::vector<int64_t>& frame_stamps) {
  Coverage c;
  std::vector<int64_t> posed;
  for (const FrameEstimate& frame : estimate.frames) {
    if (frame.restarted && !posed.empty()) ++c.restarts;  // the first world is no restart
    if (frame.pose) posed.push_back(frame.stamp_ns);
  }
  c.tracked = posed.size();
  c.frames_known = !frame_stamps.empty();
  if (!c.frames_known) {
    c.frames = estimate.frames.size();
    c.ratio = TimeCoverage(pairs, truth);
    return c;
  }
  c.frames = frame_stamps.size();
  c.ratio = double(pairs.size()) / double(c.frames);
  if (posed.empty()) {
    c.initializing = c.frames;
    return c;
  }
  c.time_to_first_pose_s = SecondsBetween(frame_stamps.front(), posed.front());
  for (const int64_t stamp : frame_stamps) {
    if (std::binary_search(posed.begin(), posed.end(), stamp)) continue;
    ++(stamp < posed.front() ? c.initializing : c.lost);
  }
  return c;
}

void CheckEnough(const Coverage& coverage, size_t pairs, const ScoreOptions& options) {
  if (pairs < size_t(options.min_pairs)) {
    throw TooLittleData(
        fmt::format("too little to score: {} poses of the estimate ({} in all) have a true pose within {:g} ms; at "
                    "least {} are needed",
                    pairs, coverage.tracked, options.association.max_difference_ms, options.min_pairs));
  }
  if (coverage.ratio < options.min_coverage_ratio) {
    throw TooLittleData(fmt::format(
        "too little to score: the estimate covers {:.1f} % of the {}; at least {:g} % are needed", 100 * coverage.ratio,
        coverage.frames_known ? "frames" : "true time span", 100 * options.min_coverage_ratio));
  }
}

void AddCoverage(const Coverage& c, const std::vector<PosePair>& pairs, Table& table) {
  Trajectory path;
  for (const PosePair& p : pairs) path.push_back({p.stamp_ns, p.truth});
  table.Add("coverage_ratio", c.ratio, "",
            c.frames_known ? "part of the frames that got a pose with a true one to compare"
                           : "part of the true time span that the estimate covers",
            Better::kHigher);
  table.Add("frames", double(c.frames), "", c.frames_known ? "frames given to the system" : "poses in the estimate",
            Better::kNeither);
  table.Add("pairs", double(pairs.size()), "", "poses compared with the truth", Better::kHigher);
  table.Add("tracked_frames", double(c.tracked), "", "frames with a pose", Better::kHigher);
  if (c.frames_known) {
    table.Add("initializing_frames", double(c.initializing), "", "frames before the first pose", Better::kLower);
    table.Add("lost_frames", double(c.lost), "", "frames without a pose after the first one", Better::kLower);
    table.Add("time_to_first_pose_s", c.time_to_first_pose_s, "s", "from the first frame to the first pose",
              Better::kLower);
  }
  table.Add("restarts", double(c.restarts), "", "times the system chose its world anew", Better::kLower);
  table.Add("duration_s", SecondsBetween(pairs.front().stamp_ns, pairs.back().stamp_ns), "s",
            "from the first compared pose to the last", Better::kNeither);
  table.Add("path_length_m", PathLength(path), "m", "length of the true path between them, sway included",
            Better::kNeither);
}

void AddAbsolute(const Scores& s, const ScoreOptions& options, Table& table) {
  table.AddStatistics("ate", s.error_se3_m, "m", "position error after SE(3) alignment");
  table.AddStatistics("ate_sim3", s.error_sim3_m, "m", "position error after Sim(3) alignment");
  table.AddStatistics("ate_rot", s.error_rot_deg, "deg", "rotation error after SE(3) alignment");
  table.AddStatistics("ate_rot_own", s.error_rot_own_deg, "deg",
                      "rotation error after the rotation that fits orientations best");
  const auto add = [&](Alignment alignment, const std::string& what) {
    const std::vector<PosePair> aligned = Apply(Align(s.pairs, alignment).X_WV, s.pairs);
    const std::string name = "ate_" + ToString(alignment);
    table.AddStatistics(name, PositionErrors(aligned), "m", "position error " + what);
    table.AddStatistics(name + "_rot", InDegrees(RotationErrors(aligned)), "deg", "rotation error " + what);
  };
  if (options.also_align == "yaw" || options.also_align == "both")
    add(Alignment::kYaw, "after yaw and position alignment");
  if (options.also_align == "none" || options.also_align == "both") add(Alignment::kNone, "without alignment");
}

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
    relative->all_pairs = o.rpe_pairs == "all";
    relative->path_of_truth = o.rpe_path == "truth";
  }
  return {
      {frames, fmt::format("{}f", o.rpe_frames), fmt::format("{} frame{}", o.rpe_frames, o.rpe_frames == 1 ? "" : "s")},
      {seconds, fmt::format("{:g}s", o.rpe_seconds), fmt::format("{:g} s", o.rpe_seconds)},
      {meters, fmt::format("{:g}m", o.rpe_meters), fmt::format("{:g} m of path", o.rpe_meters)}};
}

/// Root mean square and median of a relative error. Rotation does not depend on scale, so it stands once.
void AddRelative(const Scores& s, const RelativeInterval& interval, Table& table) {
  const auto add = [&](const Similarity& X_WV, const std::string& name, const std::string& what, bool rotation) {
    std::vector<double> translations, rotations;
    for (const RelativeError& e : RelativeErrors(Apply(X_WV, s.pairs), interval.relative)) {
      translations.push_back(e.translation_m);
      rotations.push_back(e.rotation_rad * kDegrees);
    }
    const auto row = [&](const std::string& measure, double value, const std::string& unit,
                         const std::string& meaning) {
      table.Add(name + measure + "_" + unit + "_" + interval.suffix, value, unit, meaning, Better::kLower);
    };
    const Statistics t = Summarize(translations), r = Summarize(rotations);
    const std::string over = " over " + interval.words + what;
    row("_trans_rmse", t.rmse, "m", "drift in position" + over + ", root mean square");
    row("_trans_median", t.median, "m", "drift in position" + over + ", median");
    if (!rotation) return;
    row("_rot_rmse", r.rmse, "deg", "drift in rotation" + over + ", root mean square");
    row("_rot_median", r.median, "deg", "drift in rotation" + over + ", median");
  };
  add(s.se3.X_WV, "rpe", "", true);
  add(s.sim3.X_WV, "rpe_sim3", ", scale corrected", false);
}

void AddDriftScaleAndTurn(const Scores& s, Table& table) {
  const Drift se3 = MeasureDrift(Apply(s.se3.X_WV, s.pairs)), sim3 = MeasureDrift(Apply(s.sim3.X_WV, s.pairs));
  table.Add("drift_pct", se3.translation_pct, "%", "mean error per length over sub-paths of 10 to 80 % of the path",
            Better::kLower);
  table.Add("drift_sim3_pct", sim3.translation_pct, "%", "the same, scale corrected", Better::kLower);
  table.Add("drift_rot_deg_per_m", se3.rotation_deg_per_m, "deg/m", "rotation error per length over the same sub-paths",
            Better::kLower);
  table.Add("end_drift_pct", se3.end_pct, "%", "error between first and last pose, part of the path", Better::kLower);
  table.Add("end_drift_sim3_pct", sim3.end_pct, "%", "the same, scale corrected", Better::kLower);

  const double ratio = s.sim3.scale_known ? 1 / s.sim3.X_WV.scale : kNaN;
  table.Add("scale_ratio", ratio, "", "length in the estimate over true length, by Sim(3) alignment", Better::kNearOne);
  table.Add("scale_error_pct", 100 * (ratio - 1), "%", "how much too long the estimate is", Better::kNearZero);
  table.Add("scale_drift_pct_per_m", ScaleDriftPctPerM(s.pairs), "%/m", "growth of the estimate's scale along the path",
            Better::kNearZero);

  const Turn turn = MeasureTurn(s.pairs);
  table.Add("turn_true_deg", turn.true_rad * kDegrees, "deg", "total true turn about the vertical, left plus right",
            Better::kNeither);
  table.Add("turn_estimated_deg", turn.estimated_rad * kDegrees, "deg", "total estimated turn", Better::kNeither);
  table.Add("rotation_gain", turn.Gain(), "", "estimated over true total turn; above 1 it over-turns",
            Better::kNearOne);
}

void AddTiming(const Estimate& estimate, Table& table) {
  if (!estimate.track_ms.empty()) {
    const Statistics s = Summarize(estimate.track_ms);
    table.Add("track_ms_mean", s.mean, "ms", "tracking time per frame, mean", Better::kLower);
    table.Add("track_ms_p95", QuantileOf(estimate.track_ms, 0.95), "ms", "tracking time per frame, 95th percentile",
              Better::kLower);
    table.Add("track_ms_max", s.max, "ms", "tracking time per frame, largest", Better::kLower);
  }
  table.Add("peak_memory_mb", PeakMemoryMb(), "MiB", "largest resident memory of the process so far", Better::kLower);
}

void AddRemarks(const Coverage& coverage, Scores& s) {
  if (coverage.ratio < 0.8) {
    s.remarks.push_back(
        fmt::format("low coverage: only {:.1f} % of the {} could be compared; the errors say nothing of the rest",
                    100 * coverage.ratio, coverage.frames_known ? "frames" : "true time span"));
  }
  if (coverage.restarts > 0) {
    s.remarks.push_back(fmt::format("the system chose its world anew {} time{}; one alignment serves the whole run",
                                    coverage.restarts, coverage.restarts == 1 ? "" : "s"));
  }
  if (const std::string remark = s.sim3.Remark(); !remark.empty()) s.remarks.push_back("alignment: " + remark);
  const double apart_deg = kDegrees * RotationAngle(s.se3.X_WV.rotation, AlignOrientations(s.pairs));
  if (apart_deg > 30) {
    s.remarks.push_back(fmt::format(
        "alignment by positions turns the estimate {:.0f} deg away from what its orientations say; the path is too "
        "straight or too wrong to settle it, so read ate_rot_own rather than ate_rot",
        apart_deg));
  }
}

nlohmann::ordered_json JsonOf(const std::vector<Score>& scores) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const Score& score : scores) {
    if (!std::isfinite(score.value)) {
      object[score.name] = nullptr;
    } else if (score.value == std::floor(score.value) && std::abs(score.value) < 1e15 && score.unit.empty()) {
      object[score.name] = int64_t(score.value);
    } else {
      object[score.name] = score.value;
    }
  }
  return object;
}

nlohmann::ordered_json JsonOf(const AlignmentResult& alignment) {
  const Similarity& X = alignment.X_WV;
  const Eigen::Vector4d q = X.rotation.coeffs();
  const Eigen::Vector3d t = X.translation;
  return {{"scale", X.scale},
          {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"rank", alignment.rank}};
}

}  // namespace

double Scores::Value(const std::string& name) const {
  std::vector<std::string> names;
  for (const std::vector<Score>* list : {&scores, &timing}) {
    for (const Score& score : *list) {
      if (score.name == name) return score.value;
      names.push_back(score.name);
    }
  }
  const std::string near = NearestWord(name, names);
  throw BadInput("there is no score \"" + name + "\"" + (near.empty() ? "" : "; the nearest is \"" + near + "\""));
}

Scores ScoreEstimate(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                     const ScoreOptions& options) {
  CheckFields(options, "score.");
  Scores s;
  s.pairs = AssociatePoses(estimate, truth, options.association);
  const Coverage coverage = MeasureCoverage(estimate, truth, s.pairs, frame_stamps);
  CheckEnough(coverage, s.pairs.size(), options);

  s.se3 = Align(s.pairs, Alignment::kSe3);
  s.sim3 = Align(s.pairs, Alignment::kSim3);
  for (const StampedPose& p : estimate.ToTrajectory()) {
    s.aligned_se3.push_back({p.stamp_ns, s.se3.X_WV * p.pose});
    s.aligned_sim3.push_back({p.stamp_ns, s.sim3.X_WV * p.pose});
  }
  const std::vector<PosePair> se3_pairs = Apply(s.se3.X_WV, s.pairs);
  s.error_se3_m = PositionErrors(se3_pairs);
  s.error_rot_deg = InDegrees(RotationErrors(se3_pairs));
  Similarity own;
  own.rotation = AlignOrientations(s.pairs);
  s.error_rot_own_deg = InDegrees(RotationErrors(Apply(own, s.pairs)));
  s.error_sim3_m = PositionErrors(Apply(s.sim3.X_WV, s.pairs));

  Table table(s.scores), timing(s.timing);
  AddCoverage(coverage, s.pairs, table);
  AddAbsolute(s, options, table);
  for (const RelativeInterval& interval : IntervalsOf(options)) AddRelative(s, interval, table);
  AddDriftScaleAndTurn(s, table);
  AddTiming(estimate, timing);
  AddRemarks(coverage, s);
  return s;
}

Scores ScoreWithoutPoses(const Estimate& estimate) {
  Scores s;
  Table(s.scores).Add("frames", double(estimate.frames.size()), "", "frames that the system was given",
                      Better::kNeither);
  Table timing(s.timing);
  AddTiming(estimate, timing);
  return s;
}

Estimate EstimateFromTrajectory(const Trajectory& trajectory) {
  Estimate estimate;
  for (const StampedPose& p : trajectory) {
    FrameEstimate frame;
    frame.stamp_ns = p.stamp_ns;
    frame.status = TrackingStatus::kTracking;
    frame.pose = p.pose;
    estimate.frames.push_back(frame);
  }
  return estimate;
}

std::string ScoresToJson(const Scores& scores) {
  nlohmann::ordered_json json;
  json["schema"] = "gaitcam.scores.1";
  json["scores"] = JsonOf(scores.scores);
  json["remarks"] = scores.remarks;
  json["alignment"]["se3"] = JsonOf(scores.se3);
  json["alignment"]["sim3"] = JsonOf(scores.sim3);
  json["timing"] = JsonOf(scores.timing);
  return json.dump(2) + "\n";
}

std::string ScoreText(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (value == std::floor(value) && size < 1e9) return fmt::format("{:.0f}", value);
  if (size >= 1e6 || size < 1e-6) return fmt::format("{:.3e}", value);
  const int digits_before = int(std::floor(std::log10(size))) + 1;
  return fmt::format("{:.{}f}", value, std::max(0, std::min(4 - digits_before, 7)));
}

std::string ScoresToTable(const Scores& scores) {
  size_t name_width = 0, value_width = 0, unit_width = 0;
  for (const std::vector<Score>* list : {&scores.scores, &scores.timing}) {
    for (const Score& s : *list) {
      name_width = std::max(name_width, s.name.size());
      value_width = std::max(value_width, ScoreText(s.value).size());
      unit_width = std::max(unit_width, s.unit.size());
    }
  }
  std::string text;
  for (const std::vector<Score>* list : {&scores.scores, &scores.timing}) {
    for (const Score& s : *list) {
      text += fmt::format("{:<{}}  {:>{}} {:<{}}  {}\n", s.name, name_width, ScoreText(s.value), value_width, s.unit,
                          unit_width, s.meaning);
    }
  }
  for (const std::string& remark : scores.remarks) text += "note: " + remark + "\n";
  return text;
}

}  // namespace gaitcam
