#include "results/study_report.h"

namespace gaitcam {

std::string StudyReportHtml(const StudyReportInput& input) { return input.table->name; }

}  // namespace gaitcam
