/// A place as a bag of words: ORB features (OpenCV's), each quantised to the nearest word of a vocabulary that was
/// learned before.
///
/// A window as wide as a view is described by its word counts times their inverse document frequency, the documents
/// being sections of the training images; similarity is the cosine between the view's vector and that of the best
/// window, of which there is one every 16 px. A place keeps the word and the column of each feature.

#pragma once

#include <memory>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

/// @throws BadInput without training images, or with too few features in them.
std::unique_ptr<PlaceIndex> MakeOrbWordsIndex(const PlaceIndexSetup& setup);

}  // namespace gaitcam
