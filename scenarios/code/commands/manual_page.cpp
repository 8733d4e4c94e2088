#include "scenarios/code/commands/manual_page.h"

#include <sstream>

#include "scenarios/code/commands/parser_words.h"

namespace gaitcam {
namespace {

/// A text as troff takes it for itself: backslashes and hyphens literally, no line taken for a request.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool line_begins = i == 0 || text[i - 1] == '\n';
    if (line_begins && (text[i] == '.' || text[i] == '\'')) escaped += "\\&";
    if (text[i] == '\\') {
      escaped += "\\e";
    } else if (text[i] == '-') {
      escaped += "\\-";
    } else {
      escaped += text[i];
    }
  }
  return escaped;
}

/// "KEY=VALUE"; the words of a closed set as they are; nothing for a flag.
std::string ValueOf(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  const std::string type = option.get_type_name();
  const size_t begin = type.find('{');
  if (begin != std::string::npos) return type.substr(begin);
  return type.substr(0, type.find(':'));
}

void WriteOption(std::ostream& out, const CLI::Option& option) {
  if (option.get_group().empty()) return;
  out << ".TP\n";
  if (option.nonpositional()) {
    const std::string value = ValueOf(option);
    out << "\\fB" << Escaped(CLI::detail::find_and_replace(option.get_name(false, true), ",", ", ")) << "\\fR";
    if (!value.empty()) out << " \\fI" << Escaped(value) << "\\fR";
  } else {
    out << "\\fI" << Escaped(option.get_name(true)) << "\\fR";
  }
  out << "\n" << Escaped(option.get_description());
  if (!option.get_default_str().empty()) out << " (default: " << Escaped(option.get_default_str()) << ")";
  out << "\n";
}

/// As it is, lines kept.
void WriteFooter(std::ostream& out, const std::string& footer) {
  if (!footer.empty()) out << ".PP\n.nf\n" << Escaped(footer) << "\n.fi\n";
}

void WriteVerb(std::ostream& out, const CLI::App& verb) {
  out << ".SS gaitcam " << Escaped(verb.get_name());
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->nonpositional()) out << " " << Escaped(option->get_name(true));
  }
  out << "\n" << Escaped(verb.get_description()) << "\n";
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->check_lname("help")) WriteOption(out, *option);
  }
  WriteFooter(out, verb.get_footer());
}

constexpr const char* kSurroundings = R"(.SH ENVIRONMENT
.TP
.B GAITCAM_DATA
folder of robots, scenes and scenarios, instead of those that were installed
.TP
.B GAITCAM_EGL
who renders, instead of what the scenario says under camera.renderer: auto, gpu, software, or device:N as doctor numbers
them
.TP
.B XDG_CACHE_HOME
recorded walks are kept in gaitcam/sequences of it; if it is not set, in ~/.cache
.TP
.B NO_COLOR
if set, nothing is printed bold or red; elsewhere than on a terminal it never is
.SH FILES
Results are written to the current folder (runs, datasets, studies) unless an option names another.
)";

}  // namespace

std::string ManualPage(const CLI::App& app, const std::string& version) {
  std::ostringstream out;
  out << ".TH GAITCAM 1 \"\" \"" << Escaped(version) << "\" \"User Commands\"\n"
      << ".SH NAME\ngaitcam \\- measures how well visual SLAM works on a walking robot\n"
      << ".SH SYNOPSIS\n.B gaitcam\n\\fIVERB\\fR [\\fIOPTION\\fR]...\n"
      << ".SH DESCRIPTION\n"
      << Escaped(app.get_description()) << "\n.SH OPTIONS OF ALL VERBS\n";
  for (const CLI::Option* option : app.get_options()) WriteOption(out, *option);
  out << ".SH VERBS\n";
  for (const CLI::App* verb : VisibleVerbs(app)) WriteVerb(out, *verb);
  out << ".SH EXAMPLES AND EXIT STATUS\n";
  WriteFooter(out, app.get_footer());
  out << kSurroundings;
  return out.str();
}

}  // namespace gaitcam
