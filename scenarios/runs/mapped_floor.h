/// The floor that a system mapped, against the floor of the place it walked in.

#pragma once

#include <filesystem>
#include <optional>

#include "algorithms/core/estimate.h"
#include "models/place.h"
#include "results/floor_score.h"
#include "results/score.h"

namespace gaitcam {

/// The true floor, fine enough for a map of cells of `cell_m`: two pixels per cell, but no more than 64 million in all.
FloorTruth FloorTruthOf(const Place& place, double cell_m);

/// Compares the map, if there is one, and adds its scores to those of the poses, whose SE(3) alignment places it.
std::optional<FloorComparison> AddMapScores(const Estimate& estimate, const Place& place, Scores& scores);

/// estimate.png, mask.png, truth.png and difference.png, of one size, into a folder that is made; a map of which
/// nothing can be compared gives no folder. @throws MissingResource if they cannot be written.
void WriteMapPictures(const FloorComparison& comparison, const std::filesystem::path& folder);

}  // namespace gaitcam
