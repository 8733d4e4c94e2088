/// Builds boxes, textures and lights from a scene's file.

#pragma once

#include "models/code/scenes/scene.h"
#include "models/code/scenes/scene_file.h"

namespace gaitcam {

/// @param root the file's root, for errors that name line and column.
/// @throws BadInput naming file, line, column, key and what is expected.
Scene BuildScene(const SceneFile& file, const OptionValue& root);

}  // namespace gaitcam
