/// The charts of a study's page: medians over a factor's levels, runs over measured blur, heat maps of two factors. An
/// inner part of study_report.cpp.

#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "results/reports/html_page.h"
#include "results/reports/study_report.h"

namespace gaitcam::internal {

/// The key of the chart over an axis; SIZE_MAX for the chart over blur.
std::vector<KeyEntry> StudyChartKey(const StudyReportInput& input, size_t axis);

/// Height of the chart over an axis whose labels do not fit side by side: its levels stand one below the other, over
/// the whole width of the page. Nothing for any other axis.
std::optional<int> LyingChartHeight_px(const StudyAxis& axis);

/// Data of one chart, as results/reports/page/study.js reads it: medians with bootstrap intervals at the levels of an
/// axis, a series for each level of the axis `by`.
nlohmann::ordered_json StudyEffectChart(const StudyReportInput& input, size_t axis, const Score& metric);

/// ... runs over their measured blur, and medians of bins.
nlohmann::ordered_json StudyBlurChart(const StudyReportInput& input, const Score& metric);

/// HTML: tables of medians over two axes, one for each level of `by`; empty if there are no two, or too many levels.
std::string StudyHeatMaps(const StudyReportInput& input, const Score& metric);

}  // namespace gaitcam::internal
