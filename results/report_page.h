/// The fixed parts of the report page: its style sheet and the script that draws the charts. An inner part of
/// report.cpp.

#pragma once

#include <string_view>

namespace gaitcam::internal {

/// CSS: light and dark by the reader's preference, always light on paper.
std::string_view ReportStyle();

/// JavaScript, run after Chart.js: reads the JSON of #data and draws every <canvas data-chart=...>. When done it sets
/// on <body> `data-charts` (how many canvases there are) and `data-charts-drawn` (how many of them show more than
/// axes).
std::string_view ReportScript();

}  // namespace gaitcam::internal
