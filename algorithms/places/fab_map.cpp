#include "algorithms/places/fab_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace gaitcam {
namespace {

/// Existence is never certain: a detector without false positives would else rule a place out by one word.
constexpr double kSurest = 1e-6;
constexpr double kLeastFactor = 1e-12;

std::vector<bool> Shown(const WordSet& words, size_t vocabulary) {
  std::vector<bool> shown(vocabulary, false);
  for (const int word : words) shown[size_t(word)] = true;
  return shown;
}

double LogSumExp(const std::vector<double>& logs) {
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0;
  for (const double value : logs) sum += std::exp(value - top);
  return top + std::log(sum);
}

}  // namespace

FabMapModel LearnFabMapModel(const std::vector<cv::Mat>& training, int words, uint64_t seed) {
  cv::Mat all;
  for (const cv::Mat& descriptors : training) {
    if (!descriptors.empty()) all.push_back(descriptors);
  }
  FabMapModel model;
  model.vocabulary = LearnWords(all, words, seed);
  for (const cv::Mat& descriptors : training) model.samples.push_back(WordsIn(descriptors, model.vocabulary));
  model.tree = LearnChowLiuTree(model.samples, words);
  return model;
}

FabMap::FabMap(FabMapModel model, const FabMapOptions& options) : options_(options), model_(std::move(model)) {
  CheckFields(options, "fab_map.");
  const int words = model_.vocabulary.rows;
  if (words == 0) throw BadInput("places: the vocabulary is empty, fab_map has nothing to see");
  if (model_.tree.size() != words) {
    throw BadInput("places: a tree of " + std::to_string(model_.tree.size()) + " words for a vocabulary of " +
                   std::to_string(words));
  }
  if (options.false_positive >= options.true_positive)
    throw BadOption("fab_map.false_positive: must be less than true_positive");
  const double hit = options.true_positive, false_hit = options.false_positive;
  for (const ChowLiuTree::Node& node : model_.tree.nodes) {
    prior_.push_back(float(std::clamp((node.p - false_hit) / (hit - false_hit), kSurest, 1 - kSurest)));
    auto& seen = seen_.emplace_back();
    for (const size_t exists : {0, 1}) {
      for (const size_t parent : {0, 1}) {
        const double detect = exists ? hit : false_hit, given = parent ? node.p_with_parent : node.p_without_parent;
        const double yes = detect * given / node.p, no = (1 - detect) * (1 - given) / (1 - node.p);  // (detector)
        seen[exists][parent] = yes / (yes + no);
      }
    }
  }
  if (options.new_place_model == NewPlaceModel::kSampled && model_.samples.empty())
    throw BadInput("places: fab_map.new_place_model sampled needs training images, there are none");
  for (const WordSet& sample : model_.samples) {
    CheckWords(sample);
    samples_.push_back(prior_);
    Observe(sample, samples_.back());
  }
}

void FabMap::CheckWords(const WordSet& view) const {
  GAITCAM_ASSERT(view.empty() || (view.front() >= 0 && view.back() < model_.tree.size()));
}

double FabMap::Seen(int word, bool exists, bool parent_seen) const { return seen_[size_t(word)][exists][parent_seen]; }

// ---------------------------------------------------------------------------------------------------------- likelihood

FabMap::Factors FabMap::FactorsOf(const WordSet& view) const {
  CheckWords(view);
  const std::vector<bool> shown = Shown(view, seen_.size());
  Factors factors;
  factors.without.reserve(seen_.size());
  factors.added.reserve(seen_.size());
  for (size_t word = 0; word < seen_.size(); ++word) {
    const int parent = model_.tree.nodes[word].parent;
    const size_t parent_seen = parent >= 0 && shown[size_t(parent)] ? 1 : 0;
    const double if_not = seen_[word][0][parent_seen], if_so = seen_[word][1][parent_seen];
    factors.without.push_back(shown[word] ? if_not : 1 - if_not);
    factors.added.push_back(shown[word] ? if_so - if_not : if_not - if_so);
  }
  return factors;
}

double FabMap::LogLikelihood(const Factors& factors, const Place& place) const {
  constexpr size_t kBlock = 16;  // factors to a logarithm: 1e-12^16 is a double still
  double sum = 0;
  for (size_t begin = 0; begin < place.size(); begin += kBlock) {
    double product = 1;
    for (size_t word = begin; word < std::min(begin + kBlock, place.size()); ++word)
      product *= std::max(factors.without[word] + factors.added[word] * double(place[word]), kLeastFactor);
    sum += std::log(product);
  }
  return sum;
}

double FabMap::LogLikelihoodOfNew(const Factors& factors) const {
  if (options_.new_place_model == NewPlaceModel::kMeanField) return LogLikelihood(factors, prior_);
  std::vector<double> logs;
  for (const Place& sample : samples_) logs.push_back(LogLikelihood(factors, sample));
  return LogSumExp(logs) - std::log(double(logs.size()));
}

double FabMap::LogLikelihood(const WordSet& view, size_t place) const {
  GAITCAM_ASSERT(place < places_.size());
  return LogLikelihood(FactorsOf(view), places_[place]);
}

double FabMap::LogLikelihoodOfNew(const WordSet& view) const { return LogLikelihoodOfNew(FactorsOf(view)); }

/// Bayes for each word on its own: the other words' factors do not depend on e_q.
void FabMap::Observe(const WordSet& view, Place& place) const {
  const Factors factors = FactorsOf(view);
  for (size_t word = 0; word < place.size(); ++word) {
    const double exists = double(place[word]) * (factors.without[word] + factors.added[word]);
    const double not_so = (1 - double(place[word])) * factors.without[word];
    place[word] = float(std::clamp(exists / std::max(exists + not_so, 1e-300), kSurest, 1 - kSurest));
  }
}

// ------------------------------------------------------------------------------------------------------------- places

void FabMap::Add(const Features& view) { AddWords(WordsIn(view.descriptors, model_.vocabulary)); }

void FabMap::AddWords(const WordSet& view) {
  places_.push_back(prior_);
  Observe(view, places_.back());
}

void FabMap::Update(size_t place, const WordSet& view) {
  GAITCAM_ASSERT(place < places_.size());
  Observe(view, places_[place]);
}

double FabMap::bytes_per_place() const { return places_.empty() ? 0 : double(prior_.size() * sizeof(float)); }

/// Of each place and, last, of a new one. What the last answer does not hand on to neighbours is spread evenly.
std::vector<double> FabMap::LogPrior(size_t places) const {
  double handed_on = 0;
  std::vector<double> prior(places, 0.0);
  for (size_t place = 0; place < belief_.size(); ++place) {
    for (const size_t next : {place - 1, place, place + 1}) {
      if (next >= places) continue;  // as is -1
      prior[next] += options_.motion * belief_[place] / 3;
      handed_on += options_.motion * belief_[place] / 3;
    }
  }
  for (double& p : prior) p = std::log(p + (1 - handed_on) * (1 - options_.new_place) / double(places));
  prior.push_back(std::log((1 - handed_on) * options_.new_place));
  return prior;
}

PlaceAnswer FabMap::Ask(const Features& view, size_t first_places) {
  return AskWords(WordsIn(view.descriptors, model_.vocabulary), first_places);
}

PlaceAnswer FabMap::AskWords(const WordSet& view, size_t first_places) {
  GAITCAM_ASSERT(first_places <= places_.size());
  PlaceAnswer answer;
  if (first_places == 0) return answer;
  const Factors factors = FactorsOf(view);
  std::vector<double> logs;  // of the places, then of a new one
  for (size_t place = 0; place < first_places; ++place) logs.push_back(LogLikelihood(factors, places_[place]));
  logs.push_back(LogLikelihoodOfNew(factors));

  const std::vector<double> prior = LogPrior(first_places);
  for (size_t k = 0; k < logs.size(); ++k) logs[k] += prior[k];
  const double all = LogSumExp(logs), share = (1 - options_.smoothing) / double(logs.size());
  for (size_t place = 0; place < first_places; ++place)
    answer.score.push_back(options_.smoothing * std::exp(logs[place] - all) + share);
  belief_ = answer.score;
  answer.place = int(std::max_element(logs.begin(), logs.end() - 1) - logs.begin());
  answer.known = answer.score[size_t(answer.place)] >= options_.accept;
  answer.confidence = std::exchange(logs[size_t(answer.place)], -std::numeric_limits<double>::infinity());
  answer.confidence -= LogSumExp(logs);
  return answer;
}

}  // namespace gaitcam
