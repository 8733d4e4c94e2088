/// Pictures that say at a glance what a recorded sequence holds.

#pragma once

#include <filesystem>

#include "scenarios/runs/recorded_walk.h"

namespace gaitcam {

/// An MP4 at the speed of the walk, at most 15 Hz: what the camera saw, and beside it the sharp twin if there is one.
/// The encoder gives the same pictures other bytes now and then: films are the one thing that does not repeat.
/// @throws BadInput if an image cannot be read; MissingResource if the film cannot be written whole.
void WritePreview(const RecordedWalk& walk, const std::filesystem::path& file);

/// A PNG of twelve frames over the walk. Each stands beside its sharp twin with the blur vectors drawn on it, its time
/// and its blur above.
/// @throws BadInput, MissingResource.
void WriteContactSheet(const RecordedWalk& walk, const std::string& title, const std::filesystem::path& file);

}  // namespace gaitcam
