#include "scenarios/code/runs/terminal_text.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace gaitcam {
namespace {

bool ShowsEmphasis(std::FILE* stream) {
  const char* no_colour = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  const bool unwanted = no_colour != nullptr && *no_colour != '\0';
  return !unwanted && isatty(fileno(stream)) && (terminal == nullptr || std::string_view(terminal) != "dumb");
}

std::string Emphasised(const std::string& text, const char* code, std::FILE* stream) {
  return ShowsEmphasis(stream) ? "\033[" + std::string(code) + "m" + text + "\033[0m" : text;
}

}  // namespace

std::string Bold(const std::string& text, std::FILE* stream) { return Emphasised(text, "1", stream); }

std::string Red(const std::string& text, std::FILE* stream) { return Emphasised(text, "31", stream); }

}  // namespace gaitcam
