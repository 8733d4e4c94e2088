/// What a verb prints of a run's scores: the dozen that sum it up, or all of them.

#pragma once

#include <string>
#include <vector>

#include "results/scoring/score.h"

namespace gaitcam {

/// Aligned columns for a terminal: name, value, unit, meaning; then remarks and, if some are left out, how many.
/// @param of_film further rows, which are not among the scores: of the camera's pictures.
std::string SummaryText(const Scores& scores, const std::vector<Score>& of_film, bool all);

}  // namespace gaitcam
