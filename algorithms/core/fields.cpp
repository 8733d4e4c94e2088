#include "algorithms/core/fields.h"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace gaitcam {

std::string Interval::ToText() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (!has_low && !has_high) return "a finite number";
  if (!has_high) return (low_open ? "a number greater than " : "a number of at least ") + internal::NumberText(low);
  if (!has_low) return "a number of at most " + internal::NumberText(high);
  return (low_open ? "a number greater than " : "a number from ") + internal::NumberText(low) +
         (low_open ? " and at most " : " to ") + internal::NumberText(high);
}

bool Words::Contains(const std::string& value) const {
  return words.empty() || std::find(words.begin(), words.end(), value) != words.end();
}

std::string Words::ToText() const {
  if (words.empty()) return "a text";
  std::string text = "one of ";
  for (size_t i = 0; i < words.size(); ++i) text += (i ? ", " : "") + words[i];
  return text;
}

namespace internal {

void ThrowOutOfRange(const std::string& field, const std::string& value, const std::string& permitted) {
  throw BadOption(field + ": " + value + " is not permitted; expected " + permitted);
}

std::string NumberText(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return {buffer, end};
}

}  // namespace internal

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

}  // namespace gaitcam
