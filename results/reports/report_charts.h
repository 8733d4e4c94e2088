/// The numbers that the charts of a run's page are drawn from. An inner part of report.cpp.

#pragma once

#include <cstdint>
#include <string>

#include "results/reports/report.h"

namespace gaitcam::internal {

/// Starts at the run's first frame (or true pose).
struct ReportClock {
  int64_t zero_ns = 0, end_ns = 0;
  explicit ReportClock(const ReportInput& input);
  double Seconds(int64_t stamp_ns) const { return double(stamp_ns - zero_ns) * 1e-9; }
};

bool HasPoses(const ReportInput& input);
bool HasGait(const ReportInput& input);
bool HasCovariances(const ReportInput& input);
/// So many times its true size is each ellipse of the path's chart drawn.
double PathEllipseMagnification(const ReportInput& input);

/// JSON, as results/reports/page/report.js reads it: columns over time, paths, spans without a pose.
std::string ReportChartData(const ReportInput& input);

}  // namespace gaitcam::internal
