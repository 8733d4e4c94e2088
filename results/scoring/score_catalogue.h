/// What scores there are, before any run: their names depend on the intervals that a scenario asks for.

#pragma once

#include <vector>

#include "results/scoring/score.h"

namespace gaitcam {

/// Every score of a run that is scored with these options, without a value. Timing, which differs from run to run, is
/// not among them.
std::vector<Score> ScoreCatalogue(const ScoreOptions& options);

/// The scores that a run has besides if its system maps the floor or places, without a value.
std::vector<Score> MapScoreCatalogue();

}  // namespace gaitcam
