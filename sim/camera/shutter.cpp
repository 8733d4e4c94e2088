#include "sim/camera/shutter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

ShutterInterval Around(int64_t stamp_ns, double duration_ms) {
  const auto half = int64_t(std::llround(0.5 * duration_ms * kNsPerMs));
  return {stamp_ns - half, stamp_ns + half};
}

/// The motion profile with its inverse: the instant at which a given fraction of the travel is reached.
class Progress {
 public:
  /// A twentieth of the mean speed is added everywhere, so that slots end even where nothing moves.
  explicit Progress(const MotionProfile& motion) : stamps_(motion.stamps_ns) {
    const double total = motion.travel_px.back() > 0 ? motion.travel_px.back() : 1;
    const double duration = double(stamps_.back() - stamps_.front());
    for (size_t i = 0; i < stamps_.size(); ++i) {
      progress_.push_back(motion.travel_px[i] / total + 0.05 * double(stamps_[i] - stamps_.front()) / duration);
    }
  }

  int64_t StampAt(double share) const {
    const double target = share * progress_.back();
    const size_t i = std::clamp<size_t>(
        std::upper_bound(progress_.begin(), progress_.end(), target) - progress_.begin(), 1, progress_.size() - 1);
    const double part = (target - progress_[i - 1]) / (progress_[i] - progress_[i - 1]);
    return stamps_[i - 1] + int64_t(std::llround(part * double(stamps_[i] - stamps_[i - 1])));
  }

 private:
  std::vector<int64_t> stamps_;
  std::vector<double> progress_;
};

ShutterPlan SlotsBetween(const std::vector<int64_t>& edges_ns) {
  ShutterPlan plan;
  const double duration = double(edges_ns.back() - edges_ns.front());
  for (size_t i = 0; i + 1 < edges_ns.size(); ++i) {
    const int64_t open = edges_ns[i], close = edges_ns[i + 1];
    const double weight = duration > 0 ? double(close - open) / duration : 1.0 / double(edges_ns.size() - 1);
    plan.push_back({open, close, open + (close - open) / 2, weight, Eigen::Vector2d::Zero()});
  }
  return plan;
}

ShutterPlan EqualSlots(const ShutterInterval& shutter, int count) {
  std::vector<int64_t> edges;
  for (int i = 0; i <= count; ++i) edges.push_back(shutter.open_ns + (shutter.close_ns - shutter.open_ns) * i / count);
  return SlotsBetween(edges);
}

ShutterPlan SlotsByMotion(const Progress& progress, int count) {
  std::vector<int64_t> edges;
  for (int i = 0; i <= count; ++i) edges.push_back(progress.StampAt(double(i) / count));
  return SlotsBetween(edges);
}

double LargestStep(const ShutterPlan& plan, const MotionProfile& motion) {
  double largest = 0;
  for (size_t i = 0; i + 1 < plan.size(); ++i) {
    largest = std::max(largest, motion.TravelAt(plan[i + 1].stamp_ns) - motion.TravelAt(plan[i].stamp_ns));
  }
  return largest;
}

/// Sampling offset of slot i of `count`. An image point is integrated over its path (length L) and over the pixel's
/// square. Random sampling of both is noisy; an offset that moves steadily along the path's direction is not. Moving by
/// sqrt(L^2 + 1) - L px it gives the samples the variance of path and pixel together, (L^2 + 1) / 12. Across the path
/// two offsets alternate; where hardly anything moves, four.
Eigen::Vector2d OffsetAlongMotion(const MotionProfile& motion, size_t i, size_t count) {
  constexpr double kTwoOffsets[] = {-0.25, 0.25, -0.25, 0.25}, kFourOffsets[] = {-0.125, 0.375, -0.375, 0.125};
  constexpr double kHardlyMoves_px = 2;
  const double* offsets = motion.typical_px < kHardlyMoves_px ? kFourOffsets : kTwoOffsets;
  const double walk = std::hypot(motion.typical_px, 1) - motion.typical_px;
  const double part = (double(i) + 0.5) / double(count) - 0.5;
  const Eigen::Vector2d along = motion.axis, across(-along.y(), along.x());
  // Sampling points that move against the image motion lengthen its path relative to them.
  return -part * walk * along + offsets[i % 4] * across;
}

/// A row of a rolling shutter sees only a few slots in a row: any four of these spread evenly over the pixel's square.
Eigen::Vector2d OffsetInCycle(size_t i) {
  constexpr double kX[] = {-0.125, 0.375, -0.375, 0.125}, kY[] = {-0.375, -0.125, 0.125, 0.375};
  return {kX[i % 4], kY[i % 4]};
}

void ShiftWithinPixels(const MotionProfile& motion, bool rolling, ShutterPlan& plan) {
  if (plan.size() < 2) return;
  Eigen::Vector2d mean(0, 0);
  for (size_t i = 0; i < plan.size(); ++i) {
    plan[i].shift_px = rolling ? OffsetInCycle(i) : OffsetAlongMotion(motion, i, plan.size());
    mean += plan[i].weight * plan[i].shift_px;
  }
  for (ShutterSlot& slot : plan) slot.shift_px -= mean;
}

/// At least `antialias` slots for every row: more in all where a row is open for only a part of the time.
int FewestSlots(const ExposureOptions& options, int antialias) {
  const double rows_part = options.exposure_ms / (options.exposure_ms + options.readout_ms);
  const double in_all = std::ceil(antialias / std::max(rows_part, 1e-3));
  return std::max({antialias, options.min_subframes, int(std::min<double>(in_all, options.max_subframes))});
}

}  // namespace

double MotionProfile::TravelAt(int64_t stamp_ns) const {
  const size_t after = size_t(std::upper_bound(stamps_ns.begin(), stamps_ns.end(), stamp_ns) - stamps_ns.begin());
  const size_t i = std::clamp<size_t>(after, 1, stamps_ns.size() - 1);
  const double part = double(stamp_ns - stamps_ns[i - 1]) / double(stamps_ns[i] - stamps_ns[i - 1]);
  return travel_px[i - 1] + part * (travel_px[i] - travel_px[i - 1]);
}

ShutterInterval WholeShutter(const ExposureOptions& options, int64_t stamp_ns) {
  return Around(stamp_ns, options.exposure_ms + options.readout_ms);
}

ShutterInterval MiddleRowShutter(const ExposureOptions& options, int64_t stamp_ns) {
  return Around(stamp_ns, options.exposure_ms);
}

ShutterInterval RowShutter(const ExposureOptions& options, int64_t stamp_ns, double row, int rows) {
  const double fraction = rows > 1 ? row / (rows - 1) - 0.5 : 0;
  return Around(stamp_ns + int64_t(std::llround(fraction * options.readout_ms * kNsPerMs)), options.exposure_ms);
}

ShutterPlan PlanShutter(const ExposureOptions& options, int64_t stamp_ns, int antialias, const MotionProfile& motion) {
  const ShutterInterval shutter = WholeShutter(options, stamp_ns);
  ShutterPlan plan;
  if (options.fixed_subframes > 0) {
    plan = EqualSlots(shutter, options.fixed_subframes);
  } else if (shutter.open_ns == shutter.close_ns) {
    plan = EqualSlots(shutter, antialias);
  } else {
    GAITCAM_ASSERT(motion.stamps_ns.size() >= 2 && motion.stamps_ns.size() == motion.travel_px.size());
    GAITCAM_ASSERT(motion.stamps_ns.front() == shutter.open_ns && motion.stamps_ns.back() == shutter.close_ns);
    const Progress progress(motion);
    const int fewest = FewestSlots(options, antialias), most = std::max(fewest, options.max_subframes);
    int count = std::clamp(int(std::ceil(std::min(motion.travel_px.back() / options.max_step_px, 1e6))), fewest, most);
    for (plan = SlotsByMotion(progress, count); count < most; plan = SlotsByMotion(progress, ++count)) {
      if (LargestStep(plan, motion) <= options.max_step_px) break;
    }
  }
  ShiftWithinPixels(motion, options.readout_ms > 0, plan);
  return plan;
}

std::vector<float> RowWeights(const ExposureOptions& options, int64_t stamp_ns, const ShutterPlan& plan, int row,
                              int rows) {
  std::vector<float> weights;
  if (options.readout_ms == 0) {
    for (const ShutterSlot& slot : plan) weights.push_back(float(slot.weight));
    return weights;
  }
  ShutterInterval own = RowShutter(options, stamp_ns, row, rows);
  // A row that is open for less than a slot still sees as much as one slot shows.
  const int64_t slot_ns = (plan.back().close_ns - plan.front().open_ns) / int64_t(plan.size());
  const int64_t missing = std::max<int64_t>(0, slot_ns - (own.close_ns - own.open_ns));
  own.open_ns = std::max(own.open_ns - missing / 2, plan.front().open_ns);
  own.close_ns = std::min(own.close_ns + missing / 2, plan.back().close_ns);
  double total = 0;
  std::vector<double> overlap;
  for (const ShutterSlot& slot : plan) {
    const int64_t from = std::max(slot.open_ns, own.open_ns), to = std::min(slot.close_ns, own.close_ns);
    overlap.push_back(double(std::max<int64_t>(0, to - from)));
    total += overlap.back();
  }
  for (const double part : overlap) weights.push_back(float(part / total));
  return weights;
}

std::vector<std::vector<float>> SlotWeights(const ExposureOptions& options, int64_t stamp_ns, const ShutterPlan& plan,
                                            int rows) {
  std::vector<std::vector<float>> weights(plan.size(), std::vector<float>(size_t(rows)));
  for (int row = 0; row < rows; ++row) {
    const std::vector<float> own = RowWeights(options, stamp_ns, plan, row, rows);
    for (size_t slot = 0; slot < plan.size(); ++slot) weights[slot][size_t(row)] = own[slot];
  }
  return weights;
}

std::vector<KeySlot> PlanKeys(const ShutterPlan& plan, int64_t stamp_ns, int keys) {
  GAITCAM_ASSERT(keys % 2 == 1 && keys <= int(plan.size()));
  const int count = int(plan.size());
  const auto earlier = [](const ShutterSlot& slot, int64_t stamp) { return slot.stamp_ns < stamp; };
  const double middle = double(std::lower_bound(plan.begin(), plan.end(), stamp_ns, earlier) - plan.begin()) - 0.5;
  std::vector<double> places;  // in units of sub-frames, which is near to units of motion
  for (int k = 0; k < keys; ++k) places.push_back((k + 0.5) * count / keys - 0.5);
  const auto nearest = std::min_element(
      places.begin(), places.end(), [&](double a, double b) { return std::abs(a - middle) < std::abs(b - middle); });
  *nearest = middle;
  std::vector<KeySlot> slots;
  int first = 0;
  for (size_t k = 0; k < places.size(); ++k) {
    const double end = k + 1 < places.size() ? 0.5 * (places[k] + places[k + 1]) : count;
    KeySlot slot;
    slot.stamp_ns = places.begin() + ptrdiff_t(k) == nearest ? stamp_ns : plan[size_t(std::lround(places[k]))].stamp_ns;
    slot.first = first;
    slot.end = first = std::clamp(int(std::ceil(end)), first, count);
    slots.push_back(slot);
  }
  return slots;
}

double LongestReach(const std::vector<KeySlot>& keys, const ShutterPlan& plan, const MotionProfile& motion) {
  double longest = 0;
  for (const KeySlot& key : keys) {
    const double at = motion.TravelAt(key.stamp_ns);
    for (int i = key.first; i < key.end; ++i) {
      longest = std::max(longest, std::abs(motion.TravelAt(plan[size_t(i)].stamp_ns) - at));
    }
  }
  return longest;
}

}  // namespace gaitcam
