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
  const double apart_deg = kDegPerRad * RotationAngle(s.se3.X_WV.rotation, AlignOrientations(s.pairs));
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

  s.scores = Evaluate(PoseMetrics(options, coverage.frames_known), MeasurePoses(s, coverage, options));
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
