#include "results/reports/study_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "results/reports/html_page.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

/// What a table shows of each run.
struct Shown {
  std::string name, meaning;
  std::string unit;
  double factor = 1;  ///< From the score's unit to this one.
  bool near_one = false;
  std::function<double(const StudyRun&)> value;
};

/// Metres below ten as millimetres, parts as per cent.
Shown ShowScore(const StudyTable& table, const Score& metric) {
  Shown shown{metric.name,
              metric.meaning,
              metric.unit,
              1,
              metric.better == Better::kNearOne,
              [name = metric.name](const StudyRun& run) { return run.Value(name); }};
  constexpr double kManyMetres = 10;
  const bool is_short = std::none_of(table.runs.begin(), table.runs.end(), [&](const StudyRun& run) {
    return std::abs(run.Value(metric.name)) >= kManyMetres;  // false for NaN
  });
  if (metric.unit == "m" && is_short) {
    shown.unit = "mm";
    shown.factor = 1000;
  } else if (metric.unit.empty() && metric.name.ends_with("_ratio")) {
    shown.unit = "%";
    shown.factor = 100;
  }
  return shown;
}

std::vector<Shown> AllShown(const StudyTable& table) {
  std::vector<Shown> all{
      {"blur_median_px",
       "length of the motion blur: of an image point's path during the exposure; median over image and frames", "px", 1,
       false, [](const StudyRun& run) { return run.blur_median_px; }}};
  for (const Score& metric : table.metrics) all.push_back(ShowScore(table, metric));
  return all;
}

std::string Cell(const std::vector<const StudyRun*>& runs, const Shown& shown) {
  std::vector<double> values;
  for (const StudyRun* run : runs) {
    if (const double value = shown.value(*run); std::isfinite(value)) values.push_back(shown.factor * value);
  }
  if (values.empty()) return "-";
  const auto number = [&](double quantile) {
    const double value = QuantileOf(values, quantile);
    return shown.near_one ? fmt::format("{:.3f}", value) : internal::ThreeDigits(value);
  };
  std::string text = number(0.5);
  if (runs.size() > 1) text += fmt::format(" ({} to {})", number(0), number(1));
  if (values.size() < runs.size()) text += fmt::format(" [{}]", values.size());
  return text;
}

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string HeadLine(const std::vector<std::string>& cells) {
  std::string line = "|", rule = "|";
  for (const std::string& cell : cells) {
    line += " " + cell + " |";
    rule += "---|";
  }
  return line + "\n" + rule + "\n";
}

/// One level of each of some axes.
using Combination = std::vector<size_t>;
std::vector<Combination> Combinations(const StudyTable& table, const std::vector<size_t>& axes) {
  std::vector<Combination> all{{}};
  for (const size_t axis : axes) {
    std::vector<Combination> longer;
    for (const Combination& combination : all) {
      for (size_t level = 0; level < table.axes[axis].levels.size(); ++level) {
        longer.push_back(combination);
        longer.back().push_back(level);
      }
    }
    all = std::move(longer);
  }
  return all;
}

std::string LevelsText(const StudyTable& table, const std::vector<size_t>& axes, const Combination& levels) {
  std::string text;
  for (size_t k = 0; k < axes.size(); ++k) text += (k > 0 ? ", " : "") + Escaped(table.axes[axes[k]].levels[levels[k]]);
  return text;
}

/// Which axes go down and which across.
struct Layout {
  std::vector<size_t> rows, columns;

  Layout(const StudyTable& table, size_t by) {
    constexpr size_t kMostColumns = 8;
    size_t across = 1;
    for (size_t axis = table.axes.size(); axis-- > 0;) {
      if (axis == by) continue;
      const size_t levels = table.axes[axis].levels.size();
      if (!rows.empty() || across * levels > kMostColumns) {
        rows.insert(rows.begin(), axis);
      } else {
        across *= levels;
        columns.insert(columns.begin(), axis);
      }
    }
    rows.push_back(by);
  }
  std::string Corner(const StudyTable& table) const {
    std::string text;
    for (const auto* axes : {&rows, &columns}) {
      if (axes == &columns && !columns.empty()) text += " \\ ";
      for (size_t k = 0; k < axes->size(); ++k) text += (k > 0 ? "; " : "") + table.axes[(*axes)[k]].Title();
    }
    return text;
  }
};

std::vector<const StudyRun*> RunsWith(const StudyTable& table, const Layout& layout, const Combination& row,
                                      const Combination& column) {
  std::vector<const StudyRun*> runs;
  for (const StudyRun& run : table.runs) {
    bool has = true;
    for (size_t k = 0; k < row.size(); ++k) has &= run.levels[layout.rows[k]] == row[k];
    for (size_t k = 0; k < column.size(); ++k) has &= run.levels[layout.columns[k]] == column[k];
    if (has) runs.push_back(&run);
  }
  return runs;
}

std::string TableOf(const StudyTable& table, const Layout& layout, const Shown& shown) {
  const std::vector<Combination> columns = Combinations(table, layout.columns);
  std::vector<std::string> head{layout.Corner(table)};
  for (const Combination& column : columns) head.push_back(LevelsText(table, layout.columns, column));
  std::string text = HeadLine(head);
  for (const Combination& row : Combinations(table, layout.rows)) {
    text += "| " + LevelsText(table, layout.rows, row) + " |";
    for (const Combination& column : columns) text += " " + Cell(RunsWith(table, layout, row, column), shown) + " |";
    text += "\n";
  }
  return text;
}

std::string TableOfLevels(const StudyTable& table, const std::vector<Shown>& all) {
  std::vector<std::string> head{table.axes[0].Title()};
  for (const Shown& shown : all) head.push_back(shown.name + (shown.unit.empty() ? "" : ", " + shown.unit));
  std::string text = HeadLine(head);
  for (size_t level = 0; level < table.axes[0].levels.size(); ++level) {
    text += "| " + Escaped(table.axes[0].levels[level]) + " |";
    std::vector<const StudyRun*> runs;
    for (const StudyRun& run : table.runs) {
      if (run.levels[0] == level) runs.push_back(&run);
    }
    for (const Shown& shown : all) text += " " + Cell(runs, shown) + " |";
    text += "\n";
  }
  return text;
}

std::string Head(const StudyTable& table) {
  std::map<std::string, size_t> by_status;
  for (const StudyRun& run : table.runs) ++by_status[run.status];
  const std::string description = table.description.empty() ? "" : table.description + "\n\n";
  std::string text = fmt::format("# {}\n\n{}{} runs, {} seeds for each condition", table.name, description,
                                 table.runs.size(), table.seeds);
  for (const auto& [status, runs] : by_status) text += fmt::format("; {} {}", runs, status);
  return text +
         ".\nMedian (smallest to largest) over the seeds; [n]: of n that have the score, where not all have it; "
         "-: none has it. Names that begin with `live_` are of the live answers.\n";
}

}  // namespace

std::string StudyTablesMarkdown(const StudyTable& table, std::optional<size_t> by) {
  const std::vector<Shown> all = AllShown(table);
  std::string text = Head(table);
  if (table.axes.size() == 1) return text + "\n" + TableOfLevels(table, all);
  const Layout layout(table, by.value_or(table.axes.size() - 1));
  for (const Shown& shown : all) {
    text += fmt::format("\n## {}{}\n\n{}.\n\n", shown.name, shown.unit.empty() ? "" : ", " + shown.unit, shown.meaning);
    text += TableOf(table, layout, shown);
  }
  return text;
}

}  // namespace gaitcam
