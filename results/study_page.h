/// The fixed parts of a study's page: its style sheet and the script that draws the charts. An inner part of
/// study_report.cpp.

#pragma once

#include <string_view>

namespace gaitcam::internal {

/// CSS, beside what all pages share.
std::string_view StudyStyle();

/// JavaScript, run after the shared script (html_page.h).
std::string_view StudyScript();

}  // namespace gaitcam::internal
