/// Video and contact sheet of a recorded sequence.

#pragma once

#include <filesystem>

#include "scenarios/code/runs/recorded_walk.h"

namespace gaitcam {

/// An MP4 at the speed of the walk, at most 15 Hz: the camera's images, beside the sharp twins if there are any.
/// The encoder is not deterministic: videos are the only files that are not byte-identical when recorded again.
/// @throws BadInput if an image cannot be read; MissingResource if the video cannot be written completely.
void WritePreview(const RecordedWalk& walk, const std::filesystem::path& file);

/// A PNG of twelve frames over the walk, each beside its sharp twin with blur vectors, labelled with time and blur.
/// @throws BadInput, MissingResource.
void WriteContactSheet(const RecordedWalk& walk, const std::string& title, const std::filesystem::path& file);

}  // namespace gaitcam
