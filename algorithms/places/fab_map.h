/// FAB-MAP: M. Cummins and P. Newman, "FAB-MAP: probabilistic localization and mapping in the space of appearance",
/// Int. J. of Robotics Research 27(6), 2008; the peer that Hua compares with (Table 5.1).
///
/// A view is which words of a vocabulary it shows, Z = {z_q}. A place is the probability p(e_q = 1 | L) that each thing
/// e_q exists there which makes a detector see word q. Detector: p(z_q | e_q). Words that appear together do so by the
/// Chow-Liu tree over z (chow_liu.h), learned from other scenes like the vocabulary. With z_p the word's parent,
///
///   p(Z | L) = prod_q sum_{s = 0, 1} p(z_q | e_q = s, z_p) p(e_q = s | L).
///
/// Given z_q, e_q does not depend on z_p, so by Bayes p(z_q | e_q, z_p) is proportional to
///
///   p(z_q | e_q) p(z_q | z_p) / p(z_q),                                                                 (detector)
///
/// which is normalised over z_q. A place starts from p(e_q), the value with which the detector shows a word as often as
/// the training images do, and each view of it multiplies p(e_q | L) by p(z_q | e_q, z_p).
///
/// A view of no known place: p(Z | new) is that of the average place (`mean_field`: e_q as likely as anywhere), or the
/// mean over places of which each is a training image seen once (`sampled`; these should be many more than the places
/// of the map, or by chance one of the map's fits best). The posterior over places and "new" follows from a prior; all
/// in logarithms.

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/places/chow_liu.h"
#include "algorithms/places/place_memory.h"
#include "algorithms/places/visual_words.h"

namespace gaitcam {

enum class NewPlaceModel { kMeanField, kSampled };
constexpr auto WordsOf(NewPlaceModel) {
  return std::array{EnumWord{NewPlaceModel::kMeanField, "mean_field"}, EnumWord{NewPlaceModel::kSampled, "sampled"}};
}

struct FabMapOptions {
  using DescribedTag = void;
  double true_positive = 0.61;  ///< Cummins and Newman's, as is the next one.
  double false_positive = 0;
  NewPlaceModel new_place_model = NewPlaceModel::kSampled;
  double new_place = 0.9;
  double motion = 0;
  double smoothing = 0.99;
  double accept = 0.9;
};

template <class Visitor>
void VisitFields(Visitor& visit, FabMapOptions& o) {
  visit("true_positive", o.true_positive, Between(0.01, 0.999), "probability that a detector sees what is there");
  visit("false_positive", o.false_positive, Between(0.0, 0.5), "... and what is not there");
  visit("new_place_model", o.new_place_model, EnumWords<NewPlaceModel>(), "how a place looks that was never seen");
  visit("new_place", o.new_place, Between(1e-6, 0.999999), "probability, before looking, that the place is new");
  visit("motion", o.motion, Between(0.0, 0.99),
        "share of the last answer's probability that goes on to its neighbours on the way (0: all places alike)");
  visit(
      "smoothing", o.smoothing, Between(0.5, 1.0),
      "share of a view's likelihood that is believed; the rest is spread over all places (Cummins and Newman's sigma)");
  visit("accept", o.accept, Between(0.01, 1.0), "posterior probability from which on a place is recognised");
}

/// What is learned before any place is seen, from images of other scenes.
struct FabMapModel {
  cv::Mat vocabulary;            ///< LearnWords().
  ChowLiuTree tree;              ///< One node per word.
  std::vector<WordSet> samples;  ///< Words of the training images.
};

/// @param training descriptors of each training image. @throws BadInput if there are fewer descriptors than words.
FabMapModel LearnFabMapModel(const std::vector<cv::Mat>& training, int words, uint64_t seed);

class FabMap : public PlaceMemory {
 public:
  /// @throws BadOption; BadInput for an empty vocabulary, a tree of another size, or `sampled` without samples.
  explicit FabMap(FabMapModel model, const FabMapOptions& options = {});

  void Add(const Features& view) override;
  /// score: posterior probability, smoothed; confidence: log odds of the best place without smoothing, which would make
  /// sure answers equal.
  PlaceAnswer Ask(const Features& view, size_t first_places) override;
  size_t size() const override { return places_.size(); }
  double bytes_per_place() const override;

  /// The same of a view's words. @pre each < the vocabulary's size, sorted, each once; place < size().
  void AddWords(const WordSet& view);
  /// Another view of a known place.
  void Update(size_t place, const WordSet& view);
  PlaceAnswer AskWords(const WordSet& view, size_t first_places);

  double LogLikelihood(const WordSet& view, size_t place) const;
  double LogLikelihoodOfNew(const WordSet& view) const;
  /// p(z_word = 1 | e_word, z_parent).
  double Seen(int word, bool exists, bool parent_seen) const;
  /// p(e_word = 1) of a place that was never seen.
  double Existence(int word) const { return prior_[size_t(word)]; }

 private:
  using Place = std::vector<float>;  ///< p(e_q = 1 | L).

  /// For each word p(z_q | e_q = 0, z_p) and what is added to it for e_q = 1, of a view.
  struct Factors {
    std::vector<double> without, added;
  };
  Factors FactorsOf(const WordSet& view) const;
  double LogLikelihood(const Factors& factors, const Place& place) const;
  double LogLikelihoodOfNew(const Factors& factors) const;
  void Observe(const WordSet& view, Place& place) const;
  std::vector<double> LogPrior(size_t places) const;
  void CheckWords(const WordSet& view) const;

  FabMapOptions options_;
  FabMapModel model_;
  std::vector<std::array<std::array<double, 2>, 2>> seen_;  ///< [word][exists][parent seen]
  Place prior_;
  std::vector<Place> samples_;
  std::vector<Place> places_;
  std::vector<double> belief_;  ///< Posterior of each place after the last view.
};

}  // namespace gaitcam
