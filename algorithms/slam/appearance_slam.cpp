#include "algorithms/slam/appearance_slam.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace gaitcam {
namespace {

/// For people to look at.
cv::Mat SmallPicture(const cv::Mat& image) {
  constexpr int kWidth = 240;
  cv::Mat grey = image, small;
  if (image.channels() > 1) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const double scale = double(kWidth) / grey.cols;
  cv::resize(grey, small, {kWidth, std::max(1, int(std::lround(scale * grey.rows)))}, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace

AppearanceSlam::AppearanceSlam(std::unique_ptr<PlaceMemory> memory, const ViewOptions& options,
                               const RobustViewOptions& robust, uint64_t seed)
    : memory_(std::move(memory)), options_(options), robust_options_(robust), seed_(seed), robust_(robust, seed) {
  CheckFields(options, "appearance.");
  detector_ = MakeFeature2d(options.feature);
}

AppearanceSlam::AppearanceSlam(const PirfNavSlamOptions& options, uint64_t seed)
    : AppearanceSlam(std::make_unique<PirfNav>(options.memory), options.views, options.robust, seed) {}

AppearanceSlam::AppearanceSlam(const IcgmSlamOptions& options, uint64_t seed)
    : AppearanceSlam(std::make_unique<IcgmPlaces>(GravityFilter(options.robust.icgm.icgm, seed), options.memory),
                     options.views, options.robust, seed) {}

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
  if (last_ns_ && double(observation.stamp_ns - *last_ns_) * 1e-9 < options_.every_s - kSlack_s) return estimate;
  last_ns_ = observation.stamp_ns;
  const cv::Mat& image = observation.image.pixels;
  Features features = DetectFeatures(*detector_, image, options_.max_features);
  estimate.features = features.size();
  pictures_[observation.stamp_ns] = SmallPicture(image);
  for (const RobustView& view : robust_.Add(observation.stamp_ns, {image.size(), std::move(features)})) Visit(view);
  return estimate;
}

void AppearanceSlam::Visit(const RobustView& view) {
  const int place = int(graph_.nodes.size());
  const size_t first_places = learns_ ? PlacesBefore(view.stamp_ns) : graph_.nodes.size();
  const PlaceAnswer answer = memory_->Ask(view.features, first_places);
  if (learns_) memory_->Add(view.features);
  tests_.push_back({view.stamp_ns, int(first_places), answer.place, answer.known, answer.confidence});
  const auto taken = pictures_.extract(view.stamp_ns);
  if (!learns_) return;
  const cv::Mat picture = taken.empty() ? cv::Mat() : taken.mapped();
  graph_.nodes.push_back({view.stamp_ns, 0, {}, picture});
  if (place > 0) graph_.links.push_back({place - 1, place, false, view.stamp_ns});
  if (answer.known) graph_.links.push_back({place, answer.place, true, view.stamp_ns});
  graph_.tests.push_back({view.stamp_ns, {}, {}, answer.known ? answer.place : -1, 0, picture});
}

void AppearanceSlam::Finish() {
  for (const RobustView& view : robust_.Finish()) Visit(view);
  for (PlaceNode& node : graph_.nodes) node.bytes = size_t(std::llround(memory_->bytes_per_place()));
}

void AppearanceSlam::StopLearning() {
  Finish();
  learns_ = false;
  robust_ = RobustViews(robust_options_, seed_);  // the first view has no neighbour
  last_ns_.reset();
}

}  // namespace gaitcam
