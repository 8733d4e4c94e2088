#include "results/reports/check_report.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "results/scoring/score_text.h"

namespace gaitcam {
namespace {

using tinyxml2::XMLElement;
using Rows = std::vector<std::vector<std::string>>;

std::string SpreadText(const Spread& spread) {
  if (!std::isfinite(spread.median)) return "-";
  return fmt::format("{} ({}..{})", ScoreText(spread.median), ScoreText(spread.low), ScoreText(spread.high));
}

/// "+0.0123": positive is worse.
std::string ShiftText(double value) {
  if (!std::isfinite(value)) return "-";
  return (value > 0 ? "+" : "") + ScoreText(value);
}

std::string SignificanceText(const MetricVerdict& m) {
  if (!std::isfinite(m.p_worse)) {
    if (!std::isfinite(m.interval.low)) return "-";
    return fmt::format("{} to {}", ShiftText(m.interval.low), ShiftText(m.interval.high));
  }
  return fmt::format("{:.4f}", m.p_worse);
}

std::string PairsText(const MetricVerdict& m) {
  return m.left_out == 0 ? fmt::format("{}", m.pairs) : fmt::format("{} of {}", m.pairs, m.pairs + m.left_out);
}

std::string VerdictText(const MetricVerdict& m) {
  return ToString(m.outcome) + (m.reason.empty() ? "" : ": " + m.reason);
}

std::string NameText(const MetricVerdict& m) {
  return m.metric.name + (m.metric.better == Better::kNearOne    ? " (to 1)"
                          : m.metric.better == Better::kNearZero ? " (to 0)"
                                                                 : "");
}

Rows RowsOf(const CheckReport& report) {
  Rows rows{{"scenario", "system", "metric", "baseline (range)", "now (range)", "worse by", "margin", "p", "pairs",
             "verdict"}};
  for (const EntryVerdict& entry : report.entries) {
    for (const MetricVerdict& m : entry.metrics) {
      rows.push_back({entry.scenario, entry.system, NameText(m), SpreadText(m.before), SpreadText(m.now),
                      ShiftText(m.worse_by), ScoreText(m.margin), SignificanceText(m), PairsText(m), VerdictText(m)});
    }
  }
  return rows;
}

std::vector<std::string> LostLines(const CheckReport& report) {
  std::vector<std::string> lines;
  for (const EntryVerdict& entry : report.entries) {
    for (const LostRun& lost : entry.lost)
      lines.push_back(
          fmt::format("lost: {} with {}, seed {}: {}", entry.scenario, entry.system, lost.seed, lost.reason));
    if (!entry.restless.empty()) {
      lines.push_back(
          fmt::format("restless: {} with {}: seeds not judged by themselves, as their own re-runs spread: {}",
                      entry.scenario, entry.system, fmt::join(entry.restless, ", ")));
    }
  }
  return lines;
}

int Count(const CheckReport& report, Outcome outcome) {
  int count = 0;
  for (const EntryVerdict& entry : report.entries) {
    count += int(std::count_if(entry.metrics.begin(), entry.metrics.end(),
                               [&](const MetricVerdict& m) { return m.outcome == outcome; }));
  }
  return count;
}

/// XML 1.0 has no other control characters.
std::string WithoutControls(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') c = ' ';
  }
  return text;
}

std::string NumbersLine(const MetricVerdict& m) {
  return fmt::format("baseline {}, now {}, worse by {} (margin {}), p {}, pairs {}", SpreadText(m.before),
                     SpreadText(m.now), ShiftText(m.worse_by), ScoreText(m.margin), SignificanceText(m), PairsText(m));
}

void AddOutput(XMLElement& parent, const std::string& text) {
  parent.InsertNewChildElement("system-out")->SetText(WithoutControls(text).c_str());
}

void AddProblem(XMLElement& test, const char* kind, const char* type, const MetricVerdict& m) {
  XMLElement* problem = test.InsertNewChildElement(kind);
  if (type) problem->SetAttribute("type", type);
  problem->SetAttribute("message", WithoutControls(m.reason.empty() ? NumbersLine(m) : m.reason).c_str());
  if (type) problem->SetText(NumbersLine(m).c_str());
}

void AddCase(XMLElement& suite, const CheckReport& report, const EntryVerdict& entry, const MetricVerdict& m) {
  XMLElement* test = suite.InsertNewChildElement("testcase");
  test->SetAttribute(
      "classname",
      WithoutControls(fmt::format("gaitcam.{}.{}.{}", report.suite, entry.scenario, entry.system)).c_str());
  test->SetAttribute("name", WithoutControls(m.metric.name).c_str());
  test->SetAttribute("time", "0");
  if (m.outcome == Outcome::kRegression) AddProblem(*test, "failure", "regression", m);
  if (m.outcome == Outcome::kTooFewPairs) AddProblem(*test, "error", "too few pairs", m);
  if (m.outcome == Outcome::kNotJudged) AddProblem(*test, "skipped", nullptr, m);
  AddOutput(*test, NumbersLine(m));
}

void SetCounts(XMLElement& element, const CheckReport& report) {
  size_t tests = 0;
  for (const EntryVerdict& entry : report.entries) tests += entry.metrics.size();
  element.SetAttribute("tests", uint64_t(tests));
  element.SetAttribute("failures", Count(report, Outcome::kRegression));
  element.SetAttribute("errors", Count(report, Outcome::kTooFewPairs));
  element.SetAttribute("skipped", Count(report, Outcome::kNotJudged));
  element.SetAttribute("time", fmt::format("{:.3f}", report.wall_s).c_str());
}

nlohmann::ordered_json ToJson(const Spread& spread) {
  return {{"median", spread.median}, {"low", spread.low}, {"high", spread.high}};
}

nlohmann::ordered_json ToJson(const MetricVerdict& m) {
  nlohmann::ordered_json json{{"metric", m.metric.name},
                              {"unit", m.metric.unit},
                              {"verdict", ToString(m.outcome)},
                              {"reason", m.reason},
                              {"baseline", ToJson(m.before)},
                              {"now", ToJson(m.now)},
                              {"worse_by", m.worse_by},
                              {"margin", m.margin},
                              {"p_worse", m.p_worse},
                              {"p_better", m.p_better},
                              {"pairs", m.pairs},
                              {"left_out", m.left_out}};
  if (!std::isfinite(m.p_worse)) json["interval"] = {m.interval.low, m.interval.high};
  return json;
}

}  // namespace

std::string CheckSummary(const CheckReport& report) {
  const int regressions = Count(report, Outcome::kRegression), few = Count(report, Outcome::kTooFewPairs);
  const int improved = Count(report, Outcome::kImprovement);
  if (regressions > 0) {
    for (const EntryVerdict& entry : report.entries) {
      for (const MetricVerdict& m : entry.metrics) {
        if (m.outcome != Outcome::kRegression) continue;
        const std::string more = regressions > 1 ? fmt::format(" and {} more", regressions - 1) : "";
        return fmt::format("REGRESSION: {} of {} on {}{}", m.metric.name, entry.system, entry.scenario, more);
      }
    }
  }
  if (report.entries.empty()) return "NOT EVALUATED: nothing was compared";
  if (few > 0) return fmt::format("NOT EVALUATED: {} metric{} with too few pairs", few, few == 1 ? "" : "s");
  if (improved > 0) {
    return fmt::format(
        "pass, and {} metric{} improved beyond the margin: accept that with --update, or the gate will "
        "not notice when it is lost again",
        improved, improved == 1 ? "" : "s");
  }
  return "pass";
}

std::string CheckTable(const CheckReport& report) {
  std::string text = AlignedTable(RowsOf(report), {5, 6, 7, 8});
  for (const std::string& line : LostLines(report)) text += line + "\n";
  for (const std::string& note : report.notes) text += "note: " + note + "\n";
  text += fmt::format("{}: {}: {} runs ({} reused) in {:.0f} s\n", report.suite, CheckSummary(report), report.runs,
                      report.reused, report.wall_s);
  return text;
}

std::string AlignedTable(const Rows& rows, const std::set<size_t>& numbers) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      line += numbers.count(i) ? fmt::format("{:>{}}", row[i], widths[i]) : fmt::format("{:<{}}", row[i], widths[i]);
      line += "  ";
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string MarkdownTable(const Rows& rows) {
  std::string text;
  for (size_t i = 0; i < rows.size(); ++i) {
    text += "|";
    for (const std::string& cell : rows[i]) {
      std::string safe;
      for (const char c : cell) safe += c == '|' ? "\\|" : c == '\n' ? std::string(" ") : std::string(1, c);
      text += " " + safe + " |";
    }
    text += "\n";
    if (i > 0) continue;
    text += "|";
    for (size_t k = 0; k < rows[0].size(); ++k) text += "---|";
    text += "\n";
  }
  return text;
}

std::string CheckMarkdown(const CheckReport& report) {
  std::string text = fmt::format("## gaitcam check {}: {}\n\n", report.suite, CheckSummary(report));
  text += MarkdownTable(RowsOf(report)) + "\n";
  for (const std::string& line : LostLines(report)) text += "- " + line + "\n";
  for (const std::string& note : report.notes) text += "- note: " + note + "\n";
  text += fmt::format("- {} runs, {} of them reused, {:.0f} s\n", report.runs, report.reused, report.wall_s);
  return text;
}

std::string CheckJson(const CheckReport& report) {
  nlohmann::ordered_json json{
      {"schema", "gaitcam.check.1"},     {"suite", report.suite}, {"exit_code", ExitCodeOf(report.entries)},
      {"summary", CheckSummary(report)}, {"notes", report.notes}, {"entries", nlohmann::ordered_json::array()}};
  for (const EntryVerdict& entry : report.entries) {
    nlohmann::ordered_json one{{"scenario", entry.scenario}, {"system", entry.system}};
    one["lost"] = nlohmann::ordered_json::array();
    for (const LostRun& lost : entry.lost) one["lost"].push_back({{"seed", lost.seed}, {"reason", lost.reason}});
    for (const MetricVerdict& m : entry.metrics) one["metrics"].push_back(ToJson(m));
    json["entries"].push_back(one);
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string CheckJUnit(const CheckReport& report) {
  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* suites = document.NewElement("testsuites");
  document.InsertEndChild(suites);
  suites->SetAttribute("name", "gaitcam check");
  SetCounts(*suites, report);
  XMLElement* suite = suites->InsertNewChildElement("testsuite");
  suite->SetAttribute("name", WithoutControls(report.suite).c_str());
  SetCounts(*suite, report);
  for (const EntryVerdict& entry : report.entries) {
    for (const MetricVerdict& m : entry.metrics) AddCase(*suite, report, entry, m);
  }
  std::string notes;
  for (const std::string& line : LostLines(report)) notes += line + "\n";
  for (const std::string& note : report.notes) notes += "note: " + note + "\n";
  AddOutput(*suite, notes);
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace gaitcam
