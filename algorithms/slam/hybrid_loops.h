/// Which earlier models a new one may show again: the best of each earlier pass.
///
/// Source: Hua, section 6.1.1.2: a matching score between the current model and each previous loop's models, "similar
/// to PIRF-nav2", and of each loop the three models of the best score. What a previous loop is the text does not say.
/// Here the scores themselves find them: a pass is the stretch of the way around the model whose score is the best that
/// is left, as long as the stretch before the present model that is no earlier pass; the next one lies outside of it.

#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/places/incremental_dictionary.h"

namespace gaitcam {

struct PassSearchOptions {
  using DescribedTag = void;
  DictionaryOptions dictionary;
  int passes = 2;
  int apart_models = 30;
};

template <class Visitor>
void VisitFields(Visitor& visit, PassSearchOptions& o) {
  visit("dictionary", o.dictionary, Nested(), "words by which models score are learned along the way");
  visit("passes", o.passes, Between(0, 100), "earlier passes that a model is compared with; 0: no loops");
  visit("apart_models", o.apart_models, Between(1, 100000),
        "so many models before one are no earlier pass; and to either side of the best one they are its pass");
}

class PassSearch {
 public:
  /// @throws BadOption.
  explicit PassSearch(const PassSearchOptions& options);

  /// The next model along the way. @param descriptors of its robust features.
  void Add(const cv::Mat& descriptors);
  size_t size() const { return dictionary_.places(); }

  /// Of each pass, the best first, its models of the best scores, at most three, the best first.
  /// @param first_models only the first so many models may be named. @pre first_models <= size().
  std::vector<std::vector<int>> BestOfEachPass(const cv::Mat& descriptors, size_t first_models) const;
  /// The same of all models far enough back from the newest one.
  std::vector<std::vector<int>> BestOfEachPass(const cv::Mat& descriptors) const;

 private:
  PassSearchOptions options_;
  IncrementalDictionary dictionary_;
};

}  // namespace gaitcam
