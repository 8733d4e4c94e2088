#include "algorithms/slam/robust_views.h"

#include <algorithm>
#include <utility>

namespace gaitcam {
namespace {

Features RowsOf(const Features& features, const std::vector<int>& rows) {
  Features kept;
  for (const int row : rows) {
    kept.keypoints.push_back(features.keypoints[size_t(row)]);
    kept.descriptors.push_back(features.descriptors.row(row));
  }
  return kept;
}

}  // namespace

RobustViews::RobustViews(const RobustViewOptions& options, uint64_t seed)
    : options_(options), random_(seed, "robust_views") {
  CheckFields(options, "robust.");
}

/// Views before one that it is compared with; as many after it, where these count.
size_t RobustViews::Reach() const {
  switch (options_.robust) {
    case Robustness::kNone: return 0;
    case Robustness::kPirf: return size_t(options_.pirf.window - 1);
    case Robustness::kIcgm: return size_t(options_.icgm.window - 1);
  }
  GAITCAM_ASSERT(false);
  return 0;
}

RobustView RobustViews::Ready(size_t current) {
  const FeatureImage& image = images_[current];
  RobustView view{stamps_[current], {}};
  if (options_.robust == Robustness::kNone) {
    view.features = image.features;
  } else if (options_.robust == Robustness::kIcgm) {
    view.features = RowsOf(image.features, RobustFeatures(images_, int(current), options_.icgm, random_));
  } else if (current >= Reach()) {
    const std::span<const FeatureImage> window(&images_[current - Reach()], Reach() + 1);
    const PirfSet set = ExtractPirf(window, options_.pirf).front();
    for (const std::vector<int>& rows : set.rows)
      view.features.keypoints.push_back(image.features.keypoints[size_t(rows.back())]);
    view.features.descriptors = set.descriptors;
  }
  return view;
}

std::vector<RobustView> RobustViews::Add(int64_t stamp_ns, FeatureImage image) {
  const bool both_ways = options_.robust == Robustness::kIcgm && options_.icgm.direction == IcgmDirection::kDouble;
  const size_t later = both_ways ? Reach() : 0;
  stamps_.push_back(stamp_ns);
  images_.push_back(std::move(image));
  ++waiting_;
  if (images_.size() > Reach() + later + 1) {
    stamps_.pop_front();
    images_.erase(images_.begin());
  }
  if (waiting_ <= later) return {};
  --waiting_;
  return {Ready(images_.size() - 1 - later)};
}

std::vector<RobustView> RobustViews::Finish() {
  std::vector<RobustView> views;
  for (; waiting_ > 0; --waiting_) views.push_back(Ready(images_.size() - waiting_));
  return views;
}

}  // namespace gaitcam
