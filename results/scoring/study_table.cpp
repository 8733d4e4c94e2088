#include "results/scoring/study_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

namespace gaitcam {
namespace {

std::string ConditionHeader(const StudyTable& table) {
  std::string text;
  for (const StudyAxis& axis : table.axes) text += CsvField(axis.key) + ",";
  return text + "seed,hash";
}

std::string ConditionFields(const StudyTable& table, const StudyRun& run) {
  std::string text;
  for (size_t a = 0; a < table.axes.size(); ++a) text += CsvField(table.axes[a].levels[run.levels[a]]) + ",";
  return text + fmt::format("{},{}", run.seed, run.hash);
}

}  // namespace

std::string StudyAxis::Title() const {
  static const std::map<std::string, std::string> units{{"ms", "ms"}, {"m", "m"},    {"mm", "mm"}, {"s", "s"},
                                                        {"deg", "°"}, {"hz", "Hz"},  {"px", "px"}, {"pct", "%"},
                                                        {"kg", "kg"}, {"mps", "m/s"}};
  std::string words = key.substr(key.rfind('.') + 1), unit;
  if (const size_t last = words.rfind('_'); last != std::string::npos && units.count(words.substr(last + 1)) > 0) {
    unit = ", " + units.at(words.substr(last + 1));
    words.resize(last);
  }
  if (words == "preset" && key.find('.') != std::string::npos) words = key.substr(0, key.rfind('.')) + " " + words;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words + unit;
}

std::vector<double> StudyAxis::Numbers() const {
  std::vector<double> numbers;
  for (const std::string& level : levels) {
    char* end = nullptr;
    numbers.push_back(std::strtod(level.c_str(), &end));
    if (level.empty() || *end != '\0' || !std::isfinite(numbers.back())) return {};
  }
  return numbers;
}

double StudyRun::Value(const std::string& score) const {
  const auto it = scores.find(score);
  return it == scores.end() ? NAN : it->second;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string CsvNumber(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string RunsCsv(const StudyTable& table) {
  std::string text = ConditionHeader(table) + ",status,failure,blur_median_px,frames";
  for (const std::string& name : table.score_names) {
    if (name != "frames") text += "," + name;  // it has its column already
  }
  text += "\n";
  for (const StudyRun& run : table.runs) {
    text += fmt::format("{},{},{},{},{}", ConditionFields(table, run), run.status, CsvField(run.failure),
                        CsvNumber(run.blur_median_px), run.frames);
    for (const std::string& name : table.score_names) {
      if (name != "frames") text += "," + CsvNumber(run.Value(name));
    }
    text += "\n";
  }
  return text;
}

std::string TimingsCsv(const StudyTable& table) {
  std::set<std::string> names;
  for (const StudyRun& run : table.runs) {
    for (const auto& [name, value] : run.timing) names.insert(name);
  }
  std::string text = ConditionHeader(table);
  for (const std::string& name : names) text += "," + name;
  text += "\n";
  for (const StudyRun& run : table.runs) {
    text += ConditionFields(table, run);
    for (const std::string& name : names) {
      const auto it = run.timing.find(name);
      text += "," + (it == run.timing.end() ? "" : CsvNumber(it->second));
    }
    text += "\n";
  }
  return text;
}

}  // namespace gaitcam
