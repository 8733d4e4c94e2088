#include "scenarios/code/commands/summary.h"

#include <fmt/format.h>

#include <cmath>

#include "results/scoring/score_text.h"

namespace gaitcam {
namespace {

/// Most systems state no covariance: lines without a figure would say nothing.
bool SumsUp(const Score& score) {
  return score.headline && (score.group != ScoreGroup::kConsistency || std::isfinite(score.value));
}

}  // namespace

std::string SummaryText(const Scores& scores, const std::vector<Score>& of_film, bool all) {
  Scores shown;
  size_t left_out = 0;
  for (const auto list : {&Scores::scores, &Scores::timing}) {
    for (const Score& score : scores.*list) {
      if (all || SumsUp(score)) {
        (shown.*list).push_back(score);
      } else if (!score.name.starts_with("live_")) {  // these stand in the rows of the others
        ++left_out;
      }
    }
  }
  shown.scores.insert(shown.scores.end(), of_film.begin(), of_film.end());
  shown.remarks = scores.remarks;
  std::string text = ScoresToTable(shown);
  if (left_out > 0) text += fmt::format("({} more scores with --all)\n", left_out);
  return text;
}

}  // namespace gaitcam
