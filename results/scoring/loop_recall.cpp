#include "results/scoring/loop_recall.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "algorithms/core/errors.h"

namespace gaitcam {

PrecisionRecall PrecisionRecallOf(const std::vector<LoopDecision>& decisions) {
  PrecisionRecall result;
  std::vector<LoopDecision> proposed;
  for (const LoopDecision& decision : decisions) {
    GAITCAM_ASSERT(!decision.right || (decision.proposed && decision.possible));
    result.possible += decision.possible;
    if (decision.proposed) proposed.push_back(decision);
  }
  result.views = int(decisions.size());
  if (result.possible == 0) throw TooLittleData("loops: of no view an earlier place was there to be recognised");
  std::sort(proposed.begin(), proposed.end(),
            [](const LoopDecision& a, const LoopDecision& b) { return a.confidence > b.confidence; });
  int right = 0, wrong = 0;
  double recall_before = 0;
  for (size_t k = 0; k < proposed.size(); ++k) {
    ++(proposed[k].right ? right : wrong);
    if (k + 1 < proposed.size() && proposed[k + 1].confidence == proposed[k].confidence) continue;
    const double precision = double(right) / (right + wrong), recall = double(right) / result.possible;
    result.curve.push_back({proposed[k].confidence, right, wrong, precision, recall});
    result.area += precision * (recall - recall_before);
    recall_before = recall;
    if (wrong == 0) result.recall_at_full_precision = recall;
  }
  return result;
}

std::vector<LoopDecision> JudgeLoops(const std::vector<LoopAnswer>& answers, const std::vector<Pose>& X_WC,
                                     const LoopTruthOptions& options) {
  CheckFields(options, "loops.");
  if (answers.size() != X_WC.size()) {
    throw BadInput("loops: " + std::to_string(answers.size()) + " answers, but " + std::to_string(X_WC.size()) +
                   " true poses");
  }
  const auto heading = [](const Pose& pose) {
    const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitZ();
    return std::atan2(ahead.y(), ahead.x());
  };
  const auto same = [&](const Pose& a, const Pose& b) {
    const double turn = std::remainder(heading(a) - heading(b), 2 * std::numbers::pi);
    return (a.translation - b.translation).head<2>().norm() <= options.same_place_m &&
           std::abs(turn) <= options.same_heading_deg * std::numbers::pi / 180;
  };
  std::vector<LoopDecision> decisions;
  for (size_t view = 0; view < answers.size(); ++view) {
    const LoopAnswer& answer = answers[view];
    GAITCAM_ASSERT(answer.first_places <= int(view) && answer.place < answer.first_places);
    LoopDecision decision{answer.place >= 0, answer.confidence, false, false};
    for (int place = 0; place < answer.first_places && !decision.possible; ++place)
      decision.possible = same(X_WC[view], X_WC[size_t(place)]);
    decision.right = decision.proposed && same(X_WC[view], X_WC[size_t(answer.place)]);
    decisions.push_back(decision);
  }
  return decisions;
}

}  // namespace gaitcam
