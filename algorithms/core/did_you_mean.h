/// Suggestions for a misspelt word.

#pragma once

#include <string>
#include <vector>

namespace gaitcam {

/// The candidate nearest to `word` by edit distance, or "" when none is within max(2, a third of the word's length)
/// edits.
std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b, c"
std::string JoinWords(const std::vector<std::string>& words);

/// "did you mean X?", or `otherwise` where no known word is near.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known, const std::string& otherwise);

/// "did you mean X?", or "known: a, b, c".
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known);

}  // namespace gaitcam
