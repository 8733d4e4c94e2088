#include "algorithms/places/visual_words.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

constexpr int kRounds = 10;

std::vector<int> Assign(const cv::Mat& descriptors, const cv::Mat& words) {
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(words.type() == CV_8UC1 ? cv::NORM_HAMMING : cv::NORM_L2).match(descriptors, words, matches);
  std::vector<int> nearest(size_t(descriptors.rows), 0);
  for (const cv::DMatch& match : matches) nearest[size_t(match.queryIdx)] = match.trainIdx;
  return nearest;
}

/// As many rows, each once.
cv::Mat Draw(const cv::Mat& descriptors, int words, RandomStream random) {
  std::vector<int> order(size_t(descriptors.rows), 0);
  for (size_t k = 0; k < order.size(); ++k) order[k] = int(k);
  cv::Mat drawn;
  for (int k = 0; k < words; ++k) {
    std::swap(order[size_t(k)], order[size_t(k + random.Index(descriptors.rows - k))]);
    drawn.push_back(descriptors.row(order[size_t(k)]));
  }
  return drawn;
}

/// Centres become what most of their members say, bit by bit. One without members stays.
void MoveToMajority(const cv::Mat& descriptors, const std::vector<int>& nearest, cv::Mat& centres) {
  const int words = centres.rows, bits = 8 * centres.cols;
  std::vector<int> ones(size_t(words * bits), 0), members(size_t(words), 0);
  for (int k = 0; k < descriptors.rows; ++k) {
    const int word = nearest[size_t(k)];
    ++members[size_t(word)];
    for (int bit = 0; bit < bits; ++bit)
      ones[size_t(word * bits + bit)] += descriptors.at<uchar>(k, bit / 8) >> (bit % 8) & 1;
  }
  for (int word = 0; word < words; ++word) {
    if (members[size_t(word)] == 0) continue;
    for (int byte = 0; byte < centres.cols; ++byte) {
      int value = 0;
      for (int bit = 0; bit < 8; ++bit)
        value |= (2 * ones[size_t(word * bits + 8 * byte + bit)] > members[size_t(word)]) << bit;
      centres.at<uchar>(word, byte) = uchar(value);
    }
  }
}

void MoveToMean(const cv::Mat& descriptors, const std::vector<int>& nearest, cv::Mat& centres) {
  cv::Mat sums = cv::Mat::zeros(centres.size(), CV_64FC1);
  std::vector<int> members(size_t(centres.rows), 0);
  for (int k = 0; k < descriptors.rows; ++k) {
    const int word = nearest[size_t(k)];
    ++members[size_t(word)];
    for (int d = 0; d < centres.cols; ++d) sums.at<double>(word, d) += descriptors.at<float>(k, d);
  }
  for (int word = 0; word < centres.rows; ++word) {
    if (members[size_t(word)] == 0) continue;
    for (int d = 0; d < centres.cols; ++d)
      centres.at<float>(word, d) = float(sums.at<double>(word, d) / members[size_t(word)]);
  }
}

std::string KindOf(int type, int columns) {
  const char* name = type == CV_32FC1 ? "float" : type == CV_8UC1 ? "binary" : "unknown";
  return std::to_string(columns) + " columns (" + name + ")";
}

}  // namespace

cv::Mat LearnWords(const cv::Mat& descriptors, int words, uint64_t seed) {
  if (words < 1) throw BadInput("places: a vocabulary of " + std::to_string(words) + " words; it needs one at least");
  if (descriptors.rows < words) {
    throw BadInput("places: " + std::to_string(descriptors.rows) + " features in the training images are too few for " +
                   std::to_string(words) + " words");
  }
  const bool binary = descriptors.type() == CV_8UC1;
  if (!binary && descriptors.type() != CV_32FC1)
    throw BadInput("places: words are learned of CV_32FC1 or CV_8UC1 rows");
  cv::Mat centres = Draw(descriptors, words, RandomStream(seed, binary ? "binary_words" : "float_words"));
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<int> nearest = Assign(descriptors, centres);
    binary ? MoveToMajority(descriptors, nearest, centres) : MoveToMean(descriptors, nearest, centres);
  }
  return centres;
}

std::vector<int> NearestWords(const cv::Mat& descriptors, const cv::Mat& vocabulary) {
  if (vocabulary.empty()) throw BadInput("places: the vocabulary is empty, descriptors cannot become words");
  CheckDescriptors(descriptors, vocabulary.type(), vocabulary.cols, "the vocabulary");
  return descriptors.empty() ? std::vector<int>() : Assign(descriptors, vocabulary);
}

WordSet WordsIn(const cv::Mat& descriptors, const cv::Mat& vocabulary) {
  WordSet words = NearestWords(descriptors, vocabulary);
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return words;
}

std::vector<double> InverseDocumentFrequency(const std::vector<WordSet>& documents, int words) {
  std::vector<double> documents_with(size_t(words), 0.5);
  for (const WordSet& document : documents) {
    for (const int word : document) documents_with[size_t(word)] += 1;
  }
  std::vector<double> idf;
  for (const double with : documents_with) idf.push_back(std::max(0.0, std::log(double(documents.size() + 1) / with)));
  return idf;
}

void CheckDescriptors(const cv::Mat& descriptors, int type, int columns, const char* other) {
  if (descriptors.empty() || (descriptors.type() == type && descriptors.cols == columns)) return;
  throw BadInput("places: descriptors of " + KindOf(descriptors.type(), descriptors.cols) + "; " + other + " has " +
                 KindOf(type, columns));
}

}  // namespace gaitcam
