/// A drive by a taught map on a run's page: the taught way, the driven one, people's tracks, where the robot knew where
/// it was and where it waited. A section of report.h's page.

#pragma once

#include <string>

#include "algorithms/core/taught_drive.h"
#include "results/reports/report_section.h"
#include "results/scoring/drive_score.h"

namespace gaitcam {

/// @param film its file beside the page; empty if there is none.
ReportSection DriveReportSection(const DriveComparison& comparison, const TaughtDrive& drive, const std::string& film);

/// A line for each frame: stamp_ns, state, confirmed, found, places, x_m, y_m (true), beside_m (from the taught way),
/// person_m (to the nearest one); empty where unknown.
std::string DriveCsv(const TaughtDrive& drive, const DriveComparison& comparison);

}  // namespace gaitcam
