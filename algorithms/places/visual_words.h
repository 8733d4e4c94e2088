/// A vocabulary of visual words: cluster centres of descriptors that were learned before, from other scenes.
///
/// k-means in the descriptors' own metric: Euclidean for floats; for binary descriptors the Hamming metric, where a
/// centre's bits are its members' majority (k-majority).

#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// Words that an image shows: sorted, each once.
using WordSet = std::vector<int>;

/// @param descriptors CV_32FC1 or CV_8UC1, one per row. @returns the same type, `words` rows.
/// @throws BadInput if there are fewer descriptors than words, or `words` < 1.
cv::Mat LearnWords(const cv::Mat& descriptors, int words, uint64_t seed);

/// Row of the nearest word for each descriptor. @throws BadInput for an empty vocabulary, or descriptors of another
/// type or length.
std::vector<int> NearestWords(const cv::Mat& descriptors, const cv::Mat& vocabulary);

/// What of a vocabulary an image shows. @throws as NearestWords.
WordSet WordsIn(const cv::Mat& descriptors, const cv::Mat& vocabulary);

/// log(documents / documents with the word), >= 0, of each word. One document more than there are shows nothing, and
/// each word is in half a document more: the weight of one that no document shows is finite.
std::vector<double> InverseDocumentFrequency(const std::vector<WordSet>& documents, int words);

/// @throws BadInput unless descriptors have this type and length, or are none; `other` names what they are to be
/// compared with ("the vocabulary").
void CheckDescriptors(const cv::Mat& descriptors, int type, int columns, const char* other);

}  // namespace gaitcam
