/// Parts that all pages share: self-contained HTML with charts by Chart.js, which is inlined. An inner part of
/// report.cpp, report_places.cpp and study_report.cpp.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gaitcam::internal {

/// The parts of a page that differ between pages.
struct HtmlPage {
  std::string title;
  std::string body;         ///< Inside <main>.
  std::string data;         ///< JSON, `gaitcam.data` of the script.
  std::string style = {};   ///< CSS beside what all pages share.
  std::string script = {};  ///< JavaScript; runs after Chart.js and the shared script; calls gaitcam.start(drawers).
};

/// The page as text: light and dark by the reader's preference, always light on paper. The shared script draws every
/// <canvas data-chart=...>; when done it sets on <body> `data-charts` (how many canvases there are) and
/// `data-charts-drawn` (how many of them show more than axes).
/// @param chart_library chart.min.js; empty looks in Debian's places.
/// @throws MissingResource naming the Debian package if Chart.js is not there.
std::string PageHtml(const HtmlPage& page, const std::filesystem::path& chart_library);

/// As text of HTML or XML, also within quotes.
std::string Escape(const std::string& text);

/// A picture as a data URI, no wider than `max_width_px`.
std::string JpegUri(const cv::Mat& picture, int max_width_px);

/// Three significant digits: read at a glance.
std::string ThreeDigits(double value);

/// @param kind "warn" or "bad".
std::string Banner(const std::string& kind, const std::string& head, const std::string& text);

std::string Card(const std::string& name, double value, const std::string& unit, const std::string& hint);

/// Names and values, escaped.
std::string Facts(const std::vector<std::pair<std::string, std::string>>& facts);

struct KeyEntry {
  std::string colour, text;
  std::string kind = {};    ///< "dashed" or "area" as it looks in the chart.
  std::string series = {};  ///< Label of the series that a click hides and shows; "" for none.
};

std::string Key(const std::vector<KeyEntry>& entries, const std::string& charts);

/// A chart with its title and key.
std::string Panel(const std::string& chart, const std::string& title, const std::vector<KeyEntry>& key, int height_px);

}  // namespace gaitcam::internal
