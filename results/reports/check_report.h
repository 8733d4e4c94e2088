/// Verdicts for people and machines: a table on the terminal, Markdown for a pull request, JUnit for a CI server, JSON.

#pragma once

#include <set>
#include <string>
#include <vector>

#include "results/scoring/verdict.h"

namespace gaitcam {

struct CheckReport {
  std::string suite;
  std::vector<EntryVerdict> entries;
  std::vector<std::string> notes;  ///< What a reader should know beside the verdict: another renderer, say.
  int runs = 0, reused = 0;
  double wall_s = 0;
};

/// One sentence: "pass: 8 metrics ...", "REGRESSION in ...".
std::string CheckSummary(const CheckReport& report);

/// Aligned columns, lost runs, notes and the summary.
std::string CheckTable(const CheckReport& report);
std::string CheckMarkdown(const CheckReport& report);
/// Without wall time: equal for equal runs.
std::string CheckJson(const CheckReport& report);
/// One test case per scenario, system and metric. What was not judged for want of pairs is an error, what was not
/// because coverage was lost is skipped.
std::string CheckJUnit(const CheckReport& report);

/// Rows of text under each other, two blanks between columns; those of `numbers` are flush right.
std::string AlignedTable(const std::vector<std::vector<std::string>>& rows, const std::set<size_t>& numbers = {});

/// Rows of a table for Markdown: `|` in cells is escaped.
std::string MarkdownTable(const std::vector<std::vector<std::string>>& rows);

}  // namespace gaitcam
