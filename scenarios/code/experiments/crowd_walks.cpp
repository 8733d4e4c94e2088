#include "scenarios/code/experiments/crowd_walks.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "algorithms/core/random.h"
#include "algorithms/features/icgm_sequence.h"
#include "scenarios/code/experiments/crowd_matches.h"

namespace gaitcam {
namespace {

struct Kept {
  int features = 0, on_people = 0;

  double Share() const { return double(on_people) / std::max(1, features); }
};

void AddKept(const CrowdView& view, const Features& features, const std::vector<int>& rows, Kept& kept) {
  for (const int row : rows) {
    const cv::Point2f& p = features.keypoints[size_t(row)].pt;
    ++kept.features;
    kept.on_people += view.on_people.at<uchar>(cv::Point(cvRound(p.x), cvRound(p.y))) != 0;
  }
}

/// By film, then by view.
using FoundFeatures = std::vector<std::vector<FeatureImage>>;

WalkCount CountWalk(const std::vector<CrowdWalk>& walks, const FoundFeatures& found, const std::string& detector,
                    const IcgmOptions& icgm, uint64_t seed) {
  Kept single, both;
  int images = 0;
  for (size_t w = 0; w < walks.size(); ++w) {
    RandomStream random(seed, "crowd.walk." + walks[w].scene + "." + detector);
    for (int t = 1; t + 1 < int(found[w].size()); ++t, ++images) {
      RobustFeatureOptions options;
      options.icgm = icgm;
      const auto add = [&](IcgmDirection direction, Kept& kept) {
        options.direction = direction;
        AddKept(walks[w].views[size_t(t)], found[w][size_t(t)].features, RobustFeatures(found[w], t, options, random),
                kept);
      };
      add(IcgmDirection::kSingle, single);
      add(IcgmDirection::kDouble, both);
    }
  }
  const double count = std::max(1, images);
  return {detector, "", single.features / count, both.features / count, single.Share(), both.Share()};
}

}  // namespace

std::vector<WalkCount> CountWalks(const std::vector<CrowdWalk>& walks, const std::vector<std::string>& detectors,
                                  uint64_t seed) {
  IcgmOptions automatic;
  automatic.automatic = true;
  std::vector<WalkCount> counts;
  for (const std::string& detector : detectors) {
    FoundFeatures found(walks.size());
    for (size_t w = 0; w < walks.size(); ++w)
      for (const CrowdView& view : walks[w].views)
        found[w].push_back({view.grey.size(), FindFeatures(view.grey, detector)});
    for (const auto& [name, icgm] : {std::pair{"ICGM, 0.08", IcgmOptions()},
                                     {"ICGM, automatic", automatic},
                                     {"consensus, 0.12", IcgmOptions::Consensus()}}) {
      counts.push_back(CountWalk(walks, found, detector, icgm, seed));
      counts.back().filter = name;
    }
  }
  return counts;
}

std::string WalkTable(const std::vector<WalkCount>& counts, int views) {
  std::string text = fmt::format(
      "## Single and double direction\n\n{} views of a walk in each scene, {} s apart, the camera still while it "
      "exposes; images with a neighbour on both sides. Features per image, and the share of them on people in per cent "
      "(Hua, section 6.1.3.1: 160.6 and 260.9, + 62 %).\n\n"
      "| detector | filter | single | double | more | on people, single | double "
      "|\n|---|---|---:|---:|---:|---:|---:|\n",
      views, CrowdOptions().interval_s);
  for (const WalkCount& count : counts)
    text += fmt::format("| {} | {} | {:.1f} | {:.1f} | {:+.0f} % | {:.1f} | {:.1f} |\n", count.detector, count.filter,
                        count.single, count.both, 100 * (count.both / count.single - 1), 100 * count.single_on_people,
                        100 * count.both_on_people);
  return text + "\n";
}

}  // namespace gaitcam
