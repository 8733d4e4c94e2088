/// `run` of a scenario with `localisation:`: how well places are recognised, by every method (thesis, experiment 4.6).

#pragma once

#include "scenarios/code/runs/place_views.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {

/// Makes panoramas and views, asks every method, and writes report.html, localisation.csv (one row per view and
/// method), scores.json, scenario.yaml (resolved) and heatmaps/*.png.
/// @throws BadInput before anything is rendered if robot, scene and options do not fit; MissingResource.
RunOutcome RunLocalisation(const ResolvedScenario& resolved, const RunOptions& options);

}  // namespace gaitcam
