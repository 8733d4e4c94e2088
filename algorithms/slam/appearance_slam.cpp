#include "algorithms/slam/appearance_slam.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gaitcam {

AppearanceSlam::AppearanceSlam(std::unique_ptr<PlaceMemory> memory, const AppearanceSlamOptions& options)
    : memory_(std::move(memory)), options_(options) {
  CheckFields(options, "appearance.");
  detector_ = MakeFeature2d(options.feature);
}

/// How many of the first places are older than `apart_s`.
size_t AppearanceSlam::PlacesBefore(int64_t stamp_ns) const {
  const int64_t latest_ns = stamp_ns - int64_t(std::llround(options_.apart_s * 1e9));
  const auto later = std::partition_point(graph_.nodes.begin(), graph_.nodes.end(),
                                          [&](const PlaceNode& node) { return node.stamp_ns <= latest_ns; });
  return size_t(later - graph_.nodes.begin());
}

FrameEstimate AppearanceSlam::Track(const Observation& observation) {
  FrameEstimate estimate;
  estimate.stamp_ns = observation.stamp_ns;
  constexpr double kSlack_s = 1e-3;  // stamps are rounded
  const int place = int(graph_.nodes.size());
  if (place > 0) {
    const double since_s = double(observation.stamp_ns - graph_.nodes.back().stamp_ns) * 1e-9;
    if (since_s < options_.every_s - kSlack_s) return estimate;
  }
  const Features view = DetectFeatures(*detector_, observation.image.pixels, options_.max_features);
  estimate.features = view.size();
  const size_t first_places = PlacesBefore(observation.stamp_ns);
  const PlaceAnswer answer = memory_->Ask(view, first_places);
  memory_->Add(view);
  tests_.push_back({observation.stamp_ns, int(first_places), answer.place, answer.known, answer.confidence});
  graph_.nodes.push_back({observation.stamp_ns, 0, {}});
  if (place > 0) graph_.links.push_back({place - 1, place, false, observation.stamp_ns});
  if (answer.known) graph_.links.push_back({place, answer.place, true, observation.stamp_ns});
  graph_.tests.push_back({observation.stamp_ns, {}, {}, answer.known ? answer.place : -1, 0, {}});
  return estimate;
}

void AppearanceSlam::Finish() {
  for (PlaceNode& node : graph_.nodes) node.bytes = size_t(std::llround(memory_->bytes_per_place()));
}

}  // namespace gaitcam
