/// A route map in one file:
///
///   gaitcam route map 1\n
///   N\n                     bytes of the JSON that follows
///   { ... }                 "feature", "camera", "X_BC", "candidates", "sessions", "nodes", "links" and, in "views",
///                           the size of each view
///   data                    the views in turn
///   64 hexadecimal digits   SHA-256 of all before
///
/// Of each view: key points of 8 numbers of 4 bytes (x, y, size, angle, response, octave, class_id, depth in m), little
/// endian; then descriptors. A descriptor of floats is one float, its scale, and a signed byte for each number, which
/// is byte / 127 x scale: it comes back with errors up to 0.4 % of its largest number. Bytes come back as they were.

#pragma once

#include <filesystem>

#include "algorithms/core/route_map.h"

namespace gaitcam {

/// The name of such a file in a run's folder.
inline constexpr const char* kRouteMapName = "route.map";

/// @throws MissingResource if it cannot be written.
void WriteRouteMap(const std::filesystem::path& file, const RouteMap& map);

/// @throws BadInput in one line if it cannot be read, is no such file, of another version, damaged or cut off.
RouteMap ReadRouteMap(const std::filesystem::path& file);

}  // namespace gaitcam
