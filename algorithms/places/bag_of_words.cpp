#include "algorithms/places/bag_of_words.h"

#include <algorithm>
#include <utility>

namespace gaitcam {

BagOfWords::BagOfWords(cv::Mat vocabulary, const std::vector<WordSet>& documents, const BagOfWordsOptions& options)
    : options_(options),
      vocabulary_(std::move(vocabulary)),
      idf_(InverseDocumentFrequency(documents, vocabulary_.rows)),
      shown_by_(size_t(vocabulary_.rows)) {
  CheckFields(options, "bag_of_words.");
  if (vocabulary_.empty()) throw BadInput("places: the vocabulary is empty, bag_of_words has nothing to count");
}

std::vector<double> BagOfWords::VectorOf(const Features& view) const {
  std::vector<double> vector(idf_.size(), 0.0);
  for (const int word : NearestWords(view.descriptors, vocabulary_)) vector[size_t(word)] += idf_[size_t(word)];
  const double norm = cv::norm(vector);
  if (norm > 0) {
    for (double& weight : vector) weight /= norm;
  }
  return vector;
}

void BagOfWords::Add(const Features& view) {
  const std::vector<double> vector = VectorOf(view);
  for (size_t word = 0; word < vector.size(); ++word) {
    if (vector[word] > 0) shown_by_[word].push_back({int(places_), float(vector[word])});
  }
  ++places_;
}

PlaceAnswer BagOfWords::Ask(const Features& view, size_t first_places) {
  GAITCAM_ASSERT(first_places <= places_);
  PlaceAnswer answer;
  answer.score.assign(first_places, 0.0);
  const std::vector<double> vector = VectorOf(view);
  for (size_t word = 0; word < vector.size(); ++word) {
    if (vector[word] == 0) continue;
    for (const Weight& shown : shown_by_[word]) {
      if (size_t(shown.place) >= first_places) break;
      answer.score[size_t(shown.place)] += vector[word] * double(shown.weight);
    }
  }
  const auto best = std::max_element(answer.score.begin(), answer.score.end());
  if (best == answer.score.end() || *best <= 0) return answer;
  answer.place = int(best - answer.score.begin());
  answer.confidence = *best;
  answer.known = *best >= options_.similarity;
  return answer;
}

double BagOfWords::bytes_per_place() const {
  size_t weights = 0;
  for (const std::vector<Weight>& shown : shown_by_) weights += shown.size();
  return places_ == 0 ? 0 : double(weights * sizeof(Weight)) / double(places_);
}

}  // namespace gaitcam
