/// Places as bags of words: the plain method that the others are compared with (Hua 2.1; J. Sivic and A. Zisserman,
/// "Video Google", ICCV 2003).
///
/// A view is the counts of the words that it shows, each times the word's inverse document frequency in the training
/// images; similarity is the cosine between two views. orb_words.h does the same with windows of panoramas.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/places/place_memory.h"
#include "algorithms/places/visual_words.h"

namespace gaitcam {

struct BagOfWordsOptions {
  using DescribedTag = void;
  double similarity = 0.6;
};

template <class Visitor>
void VisitFields(Visitor& visit, BagOfWordsOptions& o) {
  visit("similarity", o.similarity, Between(0.0, 1.0), "cosine from which on a place is recognised");
}

class BagOfWords : public PlaceMemory {
 public:
  /// @param vocabulary LearnWords(), of other scenes. @param documents what each training image shows.
  /// @throws BadOption; BadInput for an empty vocabulary.
  BagOfWords(cv::Mat vocabulary, const std::vector<WordSet>& documents, const BagOfWordsOptions& options = {});

  void Add(const Features& view) override;
  /// score and confidence: the cosine.
  PlaceAnswer Ask(const Features& view, size_t first_places) override;
  size_t size() const override { return places_; }
  double bytes_per_place() const override;

 private:
  struct Weight {
    int place = 0;
    float weight = 0;  ///< Of the word in the place's vector of length 1.
  };
  /// Length 1, or 0 for a view that shows nothing worth a weight.
  std::vector<double> VectorOf(const Features& view) const;

  BagOfWordsOptions options_;
  cv::Mat vocabulary_;
  std::vector<double> idf_;
  std::vector<std::vector<Weight>> shown_by_;  ///< Of each word.
  size_t places_ = 0;
};

}  // namespace gaitcam
