/// What somebody else's program says, made fit for a line of ours, a terminal, JSON and scores.

#pragma once

#include <string>
#include <string_view>

namespace gaitcam {

/// One line of valid UTF-8 without control characters: each byte that is not so becomes "?", and what is longer than a
/// thousand bytes is cut.
std::string ForeignWords(std::string_view said);

/// Poses of somebody else's further away than this are refused: scores of them would be no numbers (the Sim(3) that
/// aligns them multiplies squares of squares). It is a hundred times the way round the Earth, and no walk.
constexpr double kMaxForeignDistance_m = 4e9;

}  // namespace gaitcam
