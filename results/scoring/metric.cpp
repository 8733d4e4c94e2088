#include "results/scoring/metric.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

std::string Title(ScoreGroup group) {
  switch (group) {
    case ScoreGroup::kCoverage: return "Coverage";
    case ScoreGroup::kAbsolute: return "Absolute error";
    case ScoreGroup::kRelative: return "Relative error";
    case ScoreGroup::kDrift: return "Drift";
    case ScoreGroup::kScale: return "Scale";
    case ScoreGroup::kRotation: return "Turning";
    case ScoreGroup::kJumps: return "Jumps and time";
    case ScoreGroup::kConsistency: return "Stated uncertainty";
    case ScoreGroup::kMap: return "Map";
    case ScoreGroup::kLoops: return "Places and loops";
    case ScoreGroup::kDrive: return "Navigation";
    case ScoreGroup::kTiming: return "Time and memory: differ from run to run";
  }
  GAITCAM_ASSERT(false);
  return {};
}

}  // namespace gaitcam
