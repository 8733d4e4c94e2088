/// From what a place's file says to boxes, textures and lights.

#pragma once

#include "models/place.h"
#include "models/place_file.h"

namespace gaitcam {

/// @param root the file's root, for errors that name line and column.
/// @throws BadInput naming file, line, column, key and what is expected.
Place BuildPlace(const PlaceFile& file, const YamlNode& root);

}  // namespace gaitcam
