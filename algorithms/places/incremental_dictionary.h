/// A dictionary of features that learns as it goes, with an inverted index: which places show a word (Hua 2.2 and
/// Fig. 2.4, after PIRF-nav 2.0: N. Tongprasit, A. Kawewong and O. Hasegawa, WACV 2011).
///
/// A feature is a word that is near enough in the space of descriptors; one that no word is near becomes a word itself,
/// and stays as it was seen first. Words are searched by a k-d tree, best bin first, that grows with them: no
/// rebuilding, so that adding never takes longer than usual. (FLANN's does rebuild, and draws its trees by a global
/// random number.)

#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/best_bin_first.h"
#include "algorithms/places/visual_words.h"

namespace gaitcam {

struct DictionaryOptions {
  using DescribedTag = void;
  double max_distance = 0.25;
  int max_candidates = 100;
};

template <class Visitor>
void VisitFields(Visitor& visit, DictionaryOptions& o) {
  visit("max_distance", o.max_distance, Positive(),
        "a feature is a word no farther than this: Euclidean, or bits that differ");
  visit("max_candidates", o.max_candidates, AtLeast(0), "words compared with a feature (0: as many as it takes)");
}

class IncrementalDictionary {
 public:
  /// @throws BadOption.
  explicit IncrementalDictionary(const DictionaryOptions& options = {});

  /// The word of each descriptor; -1: none.
  /// @param descriptors CV_32FC1 or CV_8UC1, one per row. @throws BadInput if of another type or length than the words.
  std::vector<int> Find(const cv::Mat& descriptors) const;
  /// The same, where a descriptor without a word becomes one. @throws as Find(), having learned nothing.
  std::vector<int> Learn(const cv::Mat& descriptors);

  /// The next place, which shows these words. @pre sorted, each once and known.
  void AddPlace(const WordSet& words);
  /// The matching score of PIRF-nav: for each of the first N places the sum, over words that it shares with a view, of
  /// log(N / n), where n of these places show the word: what is everywhere counts nothing.
  /// @pre first_places <= places().
  std::vector<double> Score(const WordSet& view, size_t first_places) const;

  int size() const { return words_.rows; }
  size_t places() const { return places_; }
  /// Of all words, their tree and the index.
  size_t bytes() const;

 private:
  int Nearest(const cv::Mat& descriptor) const;
  void CheckLike(const cv::Mat& descriptors) const;

  DictionaryOptions options_;
  cv::Mat words_;                           ///< One per row.
  std::unique_ptr<BestBinFirstTree> tree_;  ///< None before the first word.
  std::vector<std::vector<int>> shown_by_;  ///< Of each word the places, ascending.
  size_t places_ = 0;
};

/// Words without -1, sorted, each once.
WordSet KnownWords(const std::vector<int>& words);

}  // namespace gaitcam
