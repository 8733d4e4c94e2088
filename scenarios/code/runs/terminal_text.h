/// Emphasis for people who read a terminal.

#pragma once

#include <cstdio>
#include <string>

namespace gaitcam {

/// `text` in bold or red where `stream` is a terminal that shows it: not piped, NO_COLOR not set (no-color.org), TERM
/// not "dumb". Elsewhere `text` as it is.
std::string Bold(const std::string& text, std::FILE* stream);
std::string Red(const std::string& text, std::FILE* stream);

}  // namespace gaitcam
