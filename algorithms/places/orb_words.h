/// A place by a bag of words: ORB features (OpenCV's), each taken for the nearest word of a vocabulary learned before.
///
/// Words are learned by k-majority: k-means in the Hamming metric, where a centre's bits are its members' majority. A
/// window as wide as a view is the vector of its words' numbers times their idf = log(pieces / pieces with the word),
/// with pieces those of the training images; similarity is the cosine of the angle between the view's vector and that
/// of the best window, of which there is one every 16 px. A place keeps the word and the column of each feature.

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
