/// A place as its panorama at low resolution: one byte per cell of 8 x 8 px. The baseline that every signature must
/// beat: a view, reduced likewise, slides over the panorama cell by cell; similarity is (1 + r) / 2 of the best
/// normalised correlation r.

#pragma once

#include <memory>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

/// @throws BadInput if views or panoramas are smaller than a cell.
std::unique_ptr<PlaceIndex> MakeThumbnailIndex(const PlaceIndexSetup& setup);

}  // namespace gaitcam
