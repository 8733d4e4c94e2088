/// Scores as text: JSON for programs, columns for a terminal.

#pragma once

#include <string>

#include "results/scoring/score.h"

namespace gaitcam {

/// scores.json: schema version, scores, remarks, alignments; and timing in an object of its own, so that all the rest
/// is byte-identical from run to run. Ends with a line feed.
std::string ScoresToJson(const Scores& scores);

/// Aligned columns for a terminal: name, value, unit, meaning.
std::string ScoresToTable(const Scores& scores);

/// A value as a table shows it: four significant digits, counts in full, "-" for NaN.
std::string ScoreText(double value);

}  // namespace gaitcam
