/// The floor that a system mapped, against the floor of the scene it walked in.

#pragma once

#include <filesystem>

#include "algorithms/core/floor_picture.h"
#include "models/code/scenes/scene.h"
#include "results/scoring/alignment.h"
#include "results/scoring/floor_score.h"

namespace gaitcam {

/// The true floor, fine enough for a map of cells of `cell_m`: two pixels per cell, but no more than 64 million in all.
FloorTruth FloorTruthOf(const Scene& scene, double cell_m);

/// @param X_WV the SE(3) alignment of the system's poses, which moves its map into the world of the truth.
/// @param X_WV_start that of its first pose.
FloorComparison CompareMappedFloor(const FloorPicture& map, const Scene& scene, const Similarity& X_WV,
                                   const std::optional<Similarity>& X_WV_start = std::nullopt);

/// estimate.png, mask.png, truth.png and difference.png, of one size, into a folder that is made; a map of which
/// nothing can be compared gives no folder. @throws MissingResource if they cannot be written.
void WriteMapPictures(const FloorComparison& comparison, const std::filesystem::path& folder);

}  // namespace gaitcam
