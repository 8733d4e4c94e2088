/// A place as a bag of words: ORB features (OpenCV's), each quantised to the nearest word of a vocabulary that was
/// learned before.
///
/// Words are learned by k-majority: k-means in the Hamming metric, where a centre's bits are its members' majority. A
/// window as wide as a view is described by its word counts times their inverse document frequency, the documents being
/// sections of the training images; similarity is the cosine between the view's vector and that of the best window, of
/// which there is one every 16 px. A place keeps the word and the column of each feature.

#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

class PlaceIndex;
struct PlaceIndexSetup;

/// Cluster centres of binary descriptors. @param descriptors CV_8UC1, one per row. @returns CV_8UC1, `words` rows.
/// @throws BadInput if there are fewer descriptors than words.
cv::Mat LearnBinaryWords(const cv::Mat& descriptors, int words, uint64_t seed);

/// @throws BadInput without training images, or with too few features in them.
std::unique_ptr<PlaceIndex> MakeOrbWordsIndex(const PlaceIndexSetup& setup);

}  // namespace gaitcam
