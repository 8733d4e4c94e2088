/// The tables of a study as Markdown, to be put beside what is concluded from them.

#pragma once

#include <optional>
#include <string>

#include "results/scoring/study_table.h"

namespace gaitcam {

/// tables.md: of every condition and metric the median over the seeds, the smallest and the largest; how many seeds
/// have the score where not all have it. The same bytes for the same runs. Studies of one axis have one table, a row
/// for each level; others one table for each metric.
/// @param by axis whose levels are the rows, such as systems; else the last
std::string StudyTablesMarkdown(const StudyTable& table, std::optional<size_t> by);

}  // namespace gaitcam
