/// Panoramas and views that are used again: runs that differ in what recognises places alone share one rendering.
///
/// They lie beside the recorded walks (SequenceCache) and go with them when the folder becomes too large. A set is
/// known by what decides its pictures (FramesHashOf), the very program, and the renderer.

#pragma once

#include <filesystem>
#include <optional>

#include "scenarios/code/runs/place_views.h"

namespace gaitcam {

class PlaceCache {
 public:
  /// @param folder of the cache; empty: nothing is kept, and nothing found.
  PlaceCache(const std::filesystem::path& folder, const ResolvedScenario& resolved);

  std::optional<PlaceViews> Read() const;
  /// Appears whole or not at all. A cache that cannot be written is no reason to fail: then nothing is kept.
  void Write(const PlaceViews& views) const;

 private:
  std::filesystem::path entry_;
};

}  // namespace gaitcam
