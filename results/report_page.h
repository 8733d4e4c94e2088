/// The fixed parts of a run's page: its style sheet and the script that draws the charts. An inner part of
/// report.cpp.

#pragma once

#include <string_view>

namespace gaitcam::internal {

/// CSS, beside what all pages share.
std::string_view ReportStyle();

/// JavaScript, run after the shared script (html_page.h).
std::string_view ReportScript();

}  // namespace gaitcam::internal
