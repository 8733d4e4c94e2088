#include "results/scoring/score.h"

#include <fmt/format.h>

#include <algorithm>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "results/scoring/metrics.h"
#include "results/scoring/pose_metrics.h"

namespace gaitcam {
namespace {

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

std::vector<Score> ScoreTiming(const Estimate& estimate) {
  return Evaluate(TimingMetrics(!estimate.track_ms.empty()), {estimate.track_ms, PeakMemoryMb()});
}

/// @param errors with pairs.
void MeasureErrors(const std::vector<FrameEstimate>& answer, PoseErrors& errors) {
  errors.se3 = Align(errors.pairs, Alignment::kSe3);
  errors.sim3 = Align(errors.pairs, Alignment::kSim3);
  for (const StampedPose& p : PosesOf(answer)) {
    errors.aligned_se3.push_back({p.stamp_ns, errors.se3.X_WV * p.pose});
    errors.aligned_sim3.push_back({p.stamp_ns, errors.sim3.X_WV * p.pose});
  }
  const std::vector<PosePair> se3_pairs = Apply(errors.se3.X_WV, errors.pairs);
  errors.error_se3_m = PositionErrors(se3_pairs);
  errors.error_rot_deg = InDegrees(RotationErrors(se3_pairs));
  Similarity own;
  own.rotation = AlignOrientations(errors.pairs);
  errors.error_rot_own_deg = InDegrees(RotationErrors(Apply(own, errors.pairs)));
  errors.error_sim3_m = PositionErrors(Apply(errors.sim3.X_WV, errors.pairs));
}

/// An answer that covers too little has coverage and no errors.
void ScoreLive(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
               const ScoreOptions& options, Scores& s) {
  PoseErrors errors;
  errors.pairs = AssociatePoses(estimate.live, truth, options.association);
  const Coverage coverage = MeasureCoverage(estimate.live, estimate.keyframes_only, truth, errors.pairs, frame_stamps);
  PoseMeasures measures = MeasureCoverageAlone(coverage, errors.pairs.size(), options);
  if (errors.pairs.size() >= size_t(options.min_pairs)) {
    MeasureErrors(estimate.live, errors);
    measures = MeasurePoses(errors, truth, coverage, options);
    s.live = std::move(errors);
  }
  const std::vector<Score> scores = Evaluate(LivePoseMetrics(options), measures);
  s.scores.insert(s.scores.end(), scores.begin(), scores.end());
}

void AddRemarks(const Coverage& coverage, Scores& s) {
  if (coverage.ratio < 0.8) {
    s.remarks.push_back(
        fmt::format("low coverage: only {:.1f} % of the {} could be compared; the errors say nothing of the rest",
                    100 * coverage.ratio, coverage.frames_known ? "frames" : "true time span"));
  }
  if (coverage.restarts > 0) {
    s.remarks.push_back(
        fmt::format("the system says that it chose its world anew {} time{}; one alignment serves the whole run, and "
                    "nothing is forgiven",
                    coverage.restarts, coverage.restarts == 1 ? "" : "s"));
  }
  if (const std::string remark = s.last.sim3.Remark(); !remark.empty()) s.remarks.push_back("alignment: " + remark);
  const double apart_deg = kDegPerRad * RotationAngle(s.last.se3.X_WV.rotation, AlignOrientations(s.last.pairs));
  if (apart_deg > 30) {
    s.remarks.push_back(fmt::format(
        "alignment by positions turns the estimate {:.0f} deg away from what its orientations say; the path is too "
        "straight or too wrong to settle it, so read ate_rot_own rather than ate_rot",
        apart_deg));
  }
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
  throw BadInput("there is no score \"" + name + "\"; " + DidYouMean(name, names));
}

Scores ScoreEstimate(const Estimate& estimate, const Trajectory& truth, const std::vector<int64_t>& frame_stamps,
                     const ScoreOptions& options) {
  CheckFields(options, "score.");
  Scores s;
  s.remarks = estimate.remarks;
  s.last.pairs = AssociatePoses(estimate.frames, truth, options.association);
  const Coverage coverage =
      MeasureCoverage(estimate.frames, estimate.keyframes_only, truth, s.last.pairs, frame_stamps);
  CheckEnough(coverage, s.last.pairs.size(), options);
  MeasureErrors(estimate.frames, s.last);
  s.scores = Evaluate(PoseMetrics(options, coverage.frames_known), MeasurePoses(s.last, truth, coverage, options));
  if (!estimate.live.empty() && coverage.frames_known) ScoreLive(estimate, truth, frame_stamps, options, s);
  s.timing = ScoreTiming(estimate);
  AddRemarks(coverage, s);
  if (estimate.keyframes_only) {
    s.remarks.push_back(
        fmt::format("poses of {} key frames alone: coverage counts the frames between them", coverage.tracked));
  }
  return s;
}

Scores ScoreWithoutPoses(const Estimate& estimate) {
  Scores s;
  s.scores = {{"frames", double(estimate.frames.size()), "", "frames that the system was given"}};
  s.timing = ScoreTiming(estimate);
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

}  // namespace gaitcam
