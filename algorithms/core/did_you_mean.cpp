#include "algorithms/core/did_you_mean.h"

#include <algorithm>
#include <numeric>

namespace gaitcam {

std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  size_t best_distance = std::max<size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    std::vector<size_t> row(candidate.size() + 1);  // Levenshtein distance, one row at a time
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 1; i <= word.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i;
      for (size_t j = 1; j <= candidate.size(); ++j) {
        const size_t substituted = diagonal + (word[i - 1] == candidate[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known, const std::string& otherwise) {
  const std::string near = NearestWord(word, known);
  return near.empty() ? otherwise : "did you mean " + near + "?";
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  return DidYouMean(word, known, "known: " + JoinWords(known));
}

}  // namespace gaitcam
