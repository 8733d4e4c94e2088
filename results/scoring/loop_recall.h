/// Precision and recall of loop decisions over a threshold: how many places are recognised before one is taken for
/// another.
///
/// A method answers each view with the earlier place that it thinks likeliest, and how sure it is. A threshold t
/// accepts the answers that are as sure as t, or surer:
///   precision = right / accepted,   recall = right / views of which a right answer was possible.
/// Where no earlier place is near, any answer that is accepted is wrong.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// What was said of one view, judged.
struct LoopDecision {
  bool proposed = false;  ///< An earlier place was named ...
  double confidence = 0;  ///< ... this surely; greater is surer, of one method's own scale ...
  bool right = false;     ///< ... and it is one that the view shows.
  bool possible = false;  ///< Among the places that could be named there was one that the view shows.
};

struct PrecisionRecallPoint {
  double threshold = 0;  ///< Answers as sure as this, or surer, are accepted.
  int right = 0, wrong = 0;
  double precision = 0, recall = 0;
};

struct PrecisionRecall {
  int views = 0, possible = 0;
  /// One point for each confidence that an answer has, the strictest first. Answers of equal confidence are accepted
  /// together: no threshold tells them apart. Empty if nothing was proposed.
  std::vector<PrecisionRecallPoint> curve;
  /// Average precision: the sum over the curve's points of precision times what recall gains there. No interpolation,
  /// which would flatter; what is never recalled counts as precision 0.
  double area = 0;
  double recall_at_full_precision = 0;  ///< The greatest recall without a wrong answer; 0 if the surest is wrong.
};

/// @throws TooLittleData if no right answer was possible.
PrecisionRecall PrecisionRecallOf(const std::vector<LoopDecision>& decisions);

struct LoopTruthOptions {
  using DescribedTag = void;
  double same_place_m = 1;
  double same_heading_deg = 45;
};

template <class Visitor>
void VisitFields(Visitor& visit, LoopTruthOptions& o) {
  visit("same_place_m", o.same_place_m, Between(0.01, 100.0), "two views show one place if taken no farther apart");
  visit("same_heading_deg", o.same_heading_deg, Between(0.0, 180.0),
        "... and if the camera's headings differ by no more (180: whichever way it looks)");
}

/// An answer of a method that makes a place of every view.
struct LoopAnswer {
  int place = -1;  ///< The view that it names; -1: none.
  double confidence = 0;
  int first_places = 0;  ///< Views that could be named: 0 to first_places - 1. @pre place < first_places
};

/// @param answers, X_WC of each view in the order of the film. @throws BadOption; BadInput unless as many of both.
std::vector<LoopDecision> JudgeLoops(const std::vector<LoopAnswer>& answers, const std::vector<Pose>& X_WC,
                                     const LoopTruthOptions& options = {});

}  // namespace gaitcam
