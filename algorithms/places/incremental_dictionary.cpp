#include "algorithms/places/incremental_dictionary.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {

IncrementalDictionary::IncrementalDictionary(const DictionaryOptions& options) : options_(options) {
  CheckFields(options, "dictionary.");
}

void IncrementalDictionary::CheckLike(const cv::Mat& descriptors) const {
  if (!words_.empty()) return CheckDescriptors(descriptors, words_.type(), words_.cols, "the dictionary");
  if (descriptors.empty() || descriptors.type() == CV_32FC1 || descriptors.type() == CV_8UC1) return;
  throw BadInput("places: a dictionary is made of descriptors of type CV_32FC1 or CV_8UC1");
}

int IncrementalDictionary::Nearest(const cv::Mat& descriptor) const {
  if (!tree_) return -1;
  // The tree's distances of floats are squared.
  const double within = words_.type() == CV_8UC1 ? options_.max_distance : std::pow(options_.max_distance, 2);
  const TwoNearest nearest = tree_->Search(descriptor, options_.max_candidates, float(within));
  return double(nearest.distance) <= within ? nearest.index : -1;
}

std::vector<int> IncrementalDictionary::Find(const cv::Mat& descriptors) const {
  CheckLike(descriptors);
  std::vector<int> words;
  for (int row = 0; row < descriptors.rows; ++row) words.push_back(Nearest(descriptors.row(row)));
  return words;
}

std::vector<int> IncrementalDictionary::Learn(const cv::Mat& descriptors) {
  CheckLike(descriptors);
  std::vector<int> words;
  for (int row = 0; row < descriptors.rows; ++row) {
    words.push_back(Nearest(descriptors.row(row)));
    if (words.back() >= 0) continue;
    words.back() = words_.rows;
    words_.push_back(descriptors.row(row));
    shown_by_.emplace_back();
    if (tree_) {
      tree_->Grow(words_);
    } else {
      tree_ = std::make_unique<BestBinFirstTree>(words_);
    }
  }
  return words;
}

void IncrementalDictionary::AddPlace(const WordSet& words) {
  for (const int word : words) {
    GAITCAM_ASSERT(word >= 0 && word < size());
    shown_by_[size_t(word)].push_back(int(places_));
  }
  ++places_;
}

std::vector<double> IncrementalDictionary::Score(const WordSet& view, size_t first_places) const {
  GAITCAM_ASSERT(first_places <= places_);
  std::vector<double> score(first_places, 0.0);
  for (const int word : view) {
    const std::vector<int>& places = shown_by_[size_t(word)];
    const auto end = std::lower_bound(places.begin(), places.end(), int(first_places));
    if (end == places.begin()) continue;
    const double weight = std::log(double(first_places) / double(end - places.begin()));
    for (auto place = places.begin(); place != end; ++place) score[size_t(*place)] += weight;
  }
  return score;
}

size_t IncrementalDictionary::bytes() const {
  size_t sum = words_.total() * words_.elemSize() + (tree_ ? tree_->bytes() : 0);
  for (const std::vector<int>& places : shown_by_) sum += sizeof(std::vector<int>) + places.capacity() * sizeof(int);
  return sum;
}

WordSet KnownWords(const std::vector<int>& words) {
  WordSet known = words;
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  if (!known.empty() && known.front() < 0) known.erase(known.begin());
  return known;
}

}  // namespace gaitcam
