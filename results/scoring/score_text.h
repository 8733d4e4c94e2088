/// Scores as text: JSON for programs, columns for a terminal.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "results/scoring/score.h"

namespace gaitcam {

/// scores.json: schema version, scores, remarks, alignments; and timing in an object of its own, so that all the rest
/// is byte-identical from run to run. Ends with a line feed.
std::string ScoresToJson(const Scores& scores);

/// A row of a table: the same metric of both answers.
struct ScoreRow {
  Score last;                  ///< Of the final answer, or of neither.
  std::optional<double> live;  ///< Of the live one, if there is such a score.
};
/// Scores named "live_NAME" join the row of NAME.
std::vector<ScoreRow> JoinAnswers(const std::vector<Score>& scores);

/// Aligned columns for a terminal: name, value (final and live, where there are both), unit, meaning.
std::string ScoresToTable(const Scores& scores);

/// A value as a table shows it: four significant digits, counts in full, "-" for NaN.
std::string ScoreText(double value);

}  // namespace gaitcam
