/// The report of a study: one self-contained HTML page.

#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "results/scoring/study_effects.h"
#include "results/scoring/study_table.h"

namespace gaitcam {

struct StudyReportInput {
  const StudyTable* table = nullptr;
  const std::vector<StudyEffect>* effects = nullptr;  ///< Ranked.
  StudyStatistics statistics;
  std::optional<size_t> by;  ///< Axis whose levels are the series of charts, such as systems.
  std::string study_file;    ///< YAML text.
  std::vector<std::pair<std::string, std::string>> facts;  ///< Name and value: command, versions, renderer.
};

/// The page as text. @throws MissingResource naming the Debian package if Chart.js is not there.
std::string StudyReportHtml(const StudyReportInput& input);

}  // namespace gaitcam
