#include "algorithms/slam/hybrid_loops.h"

#include <algorithm>

namespace gaitcam {

PassSearch::PassSearch(const PassSearchOptions& options) : options_(options), dictionary_(options.dictionary) {
  CheckFields(options, "passes.");
}

void PassSearch::Add(const cv::Mat& descriptors) { dictionary_.AddPlace(KnownWords(dictionary_.Learn(descriptors))); }

std::vector<std::vector<int>> PassSearch::BestOfEachPass(const cv::Mat& descriptors, size_t first_models) const {
  constexpr size_t kBest = 3;  // Hua's
  std::vector<std::vector<int>> passes;
  if (first_models == 0) return passes;
  std::vector<double> scores = dictionary_.Score(KnownWords(dictionary_.Find(descriptors)), first_models);
  while (int(passes.size()) < options_.passes) {
    const int peak = int(std::max_element(scores.begin(), scores.end()) - scores.begin());
    if (!(scores[size_t(peak)] > 0)) break;
    std::vector<int> models;
    const int end = std::min(int(first_models), peak + options_.apart_models + 1);
    for (int model = std::max(0, peak - options_.apart_models); model < end; ++model) {
      if (scores[size_t(model)] > 0) models.push_back(model);
    }
    std::stable_sort(models.begin(), models.end(), [&](int a, int b) { return scores[size_t(a)] > scores[size_t(b)]; });
    for (const int model : models) scores[size_t(model)] = 0;  // taken
    models.resize(std::min(models.size(), kBest));
    passes.push_back(std::move(models));
  }
  return passes;
}

std::vector<std::vector<int>> PassSearch::BestOfEachPass(const cv::Mat& descriptors) const {
  const size_t apart = size_t(options_.apart_models);
  return BestOfEachPass(descriptors, size() > apart ? size() - apart : 0);
}

}  // namespace gaitcam
