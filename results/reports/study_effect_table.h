/// The comparisons of a study as a table of its page. An inner part of study_report.cpp.

#pragma once

#include <string>

#include "results/reports/study_report.h"

namespace gaitcam::internal {

/// HTML: each level against its axis's reference, the surest first; rows beyond the first are folded.
std::string StudyEffectTable(const StudyReportInput& input);

}  // namespace gaitcam::internal
