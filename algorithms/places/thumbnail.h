/// A place by its panorama as it is, much smaller: one byte per cell of 8 x 8 px. The plain comparison that every
/// signature must beat: a view, shrunk likewise, slides over the panorama cell by cell; similarity is (1 + r) / 2 of
/// the best normalised correlation r.

#pragma once

#include <memory>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

/// @throws BadInput if views or panoramas are smaller than a cell.
std::unique_ptr<PlaceIndex> MakeThumbnailIndex(const PlaceIndexSetup& setup);

}  // namespace gaitcam
