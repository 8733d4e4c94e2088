#include "scenarios/code/datasets/settings_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "algorithms/core/file_content.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/program_settings.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool BeginsNumber(const char* at, const char* end) {
  if (at < end && *at == '-') ++at;
  return at < end && std::isdigit(static_cast<unsigned char>(*at)) != 0;
}

/// The same but for the last digits of numbers, which another version of a library may round otherwise.
bool SameButRounding(const std::string& a, const std::string& b) {
  const char *p = a.data(), *q = b.data(), *const p_end = p + a.size(), *const q_end = q + b.size();
  while (p < p_end && q < q_end) {
    if (!BeginsNumber(p, p_end) || !BeginsNumber(q, q_end)) {
      if (*p++ != *q++) return false;
      continue;
    }
    double x = 0, y = 0;
    p = std::from_chars(p, p_end, x).ptr;
    q = std::from_chars(q, q_end, y).ptr;
    if (!(std::abs(x - y) <= 1e-9 * std::max(1.0, std::abs(y)))) return false;
  }
  return p == p_end && q == q_end;
}

/// The first line that differs; nothing where none does.
std::optional<Problem> FirstDifference(const fs::path& file, const std::string& expected) {
  const std::optional<std::string> text = FindFileContent(file);
  if (!text) return Problem{file, 0, "there is no such file; a recording holds these settings for other programs"};
  const std::vector<std::string> is = Lines(*text), should_be = Lines(expected);
  for (size_t i = 0; i < std::max(is.size(), should_be.size()); ++i) {
    const std::string here = i < is.size() ? is[i] : "", there = i < should_be.size() ? should_be[i] : "";
    if (SameButRounding(here, there)) continue;
    return Problem{file, int(i) + 1, fmt::format("says \"{}\", by the calibration expected \"{}\"", here, there)};
  }
  return std::nullopt;
}

void CheckStampList(const fs::path& file, const std::vector<int64_t>& frames, Problems& problems) {
  CheckedTable table(file, ' ', 1, problems);
  if (!table.was_read()) return;
  if (table.leading_comments() > 0) table.FailWhole("begins with a comment, which its readers take for a stamp");
  CompareStamps(table.Stamps(false), table, frames, "the table of images");
}

}  // namespace

void CheckSettings(const fs::path& dataset, DatasetFormat format, const Calibration& calibration,
                   const std::vector<int64_t>& frames, Problems& problems) {
  for (const ProgramSettings& settings : SettingsOf(calibration, format)) {
    if (auto problem = FirstDifference(dataset / settings.file, settings.text)) problems.push_back(*problem);
  }
  if (format == DatasetFormat::kEuroc) CheckStampList(StampListOf(dataset), frames, problems);
  if (format != DatasetFormat::kVslamlab) return;
  const fs::path file = dataset / "calibration.yaml";
  const auto coloured = FirstDifference(file, VslamlabCalibrationText(calibration, false));
  if (coloured && FirstDifference(file, VslamlabCalibrationText(calibration, true))) problems.push_back(*coloured);
}

}  // namespace gaitcam
