#include "scenarios/code/experiments/perturbed_stream.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/core.hpp>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/core/units.h"
#include "scenarios/code/runs/handicap.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

using Frames = std::vector<HandedOver>;

int64_t ShutterClose_ns(const Observation& o) { return o.stamp_ns + std::llround(0.5 * kNsPerMs * o.exposure_ms); }

template <class Visit>
void ForImages(Observation& o, Visit visit) {
  visit(o.image);
  if (o.right) visit(*o.right);
}

void Prepend(Observation& to, Observation& from) {
  const auto prepend = [](auto& late, auto& early) {
    late.insert(late.begin(), std::make_move_iterator(early.begin()), std::make_move_iterator(early.end()));
  };
  prepend(to.imu, from.imu);
  prepend(to.joints, from.joints);
  prepend(to.odometry, from.odometry);
}

/// Moves the readings up to an instant from one observation to another that has none.
void TakeReadings(Observation& from, Observation& to, int64_t until_ns) {
  const auto take = [until_ns](auto& source, auto& target) {
    const auto end = std::find_if(source.begin(), source.end(), [&](const auto& s) { return s.stamp_ns > until_ns; });
    target.assign(source.begin(), end);
    source.erase(source.begin(), end);
  };
  take(from.imu, to.imu);
  take(from.joints, to.joints);
  take(from.odometry, to.odometry);
}

/// Shifts an observation with its images in time; its readings keep their stamps.
void Restamp(Observation& o, int64_t stamp_ns) {
  const int64_t shift_ns = stamp_ns - o.stamp_ns;
  ForImages(o, [=](Image& image) { image.stamp_ns += shift_ns; });
  if (o.depth) o.depth->stamp_ns += shift_ns;
  o.stamp_ns = stamp_ns;
}

/// The images of `shown` under the stamp of `o`.
void Show(Observation& o, const Observation& shown) {
  const int64_t stamp_ns = std::exchange(o.stamp_ns, shown.stamp_ns);
  o.exposure_ms = shown.exposure_ms;
  o.image = shown.image;
  o.right = shown.right;
  o.depth = shown.depth;
  Restamp(o, stamp_ns);
}

/// Readings of a lost frame come with the next one, as they do where a camera drops frames.
void Drop(RecordedStream& stream, double percent, RandomStream& random) {
  Frames kept;
  Observation lost;
  for (HandedOver& frame : stream.frames) {
    if (random.Uniform() < 0.01 * percent) {
      Prepend(frame.observation, lost);
      lost = std::move(frame.observation);
      continue;
    }
    Prepend(frame.observation, lost);
    lost = Observation();
    kept.push_back(std::move(frame));
  }
  stream.frames = std::move(kept);
}

/// The copy comes half-way to the next frame, with the readings up to then; the last frame has no copy.
void Double(RecordedStream& stream, double percent, RandomStream& random) {
  Frames all;
  for (size_t i = 0; i < stream.frames.size(); ++i) {
    all.push_back(std::move(stream.frames[i]));
    const bool is_doubled = random.Uniform() < 0.01 * percent;
    if (!is_doubled || i + 1 == stream.frames.size()) continue;
    Observation& next = stream.frames[i + 1].observation;
    const Observation& shown = all.back().observation;
    Observation copy;
    copy.stamp_ns = shown.stamp_ns + (next.stamp_ns - shown.stamp_ns) / 2;
    copy.scan = shown.scan;
    Show(copy, shown);
    TakeReadings(next, copy, ShutterClose_ns(copy));
    all.push_back({std::move(copy), std::nullopt});
  }
  stream.frames = std::move(all);
}

/// Pairs do not overlap, so that more of them never undo one: each has a number of its own.
void Swap(RecordedStream& stream, double percent, RandomStream& random) {
  for (size_t i = 0; i + 1 < stream.frames.size(); i += 2) {
    if (random.Uniform() >= 0.01 * percent) continue;
    HandedOver &first = stream.frames[i], &second = stream.frames[i + 1];
    const Observation shown_first = first.observation;
    Show(first.observation, second.observation);
    Show(second.observation, shown_first);
    std::swap(first.shown_ns, second.shown_ns);
  }
}

/// In the middle of the recording, so that there is a map before and something to track after it.
void Freeze(RecordedStream& stream, double duration_s, RandomStream& random) {
  const double begin = random.Uniform(0.4, 0.6);
  if (stream.frames.empty()) return;
  const int64_t first_ns = stream.frames.front().observation.stamp_ns;
  const int64_t last_ns = stream.frames.back().observation.stamp_ns;
  const int64_t begin_ns = first_ns + std::llround(begin * double(last_ns - first_ns));
  const int64_t end_ns = begin_ns + std::llround(1e9 * duration_s);
  const Observation* shown = nullptr;
  for (HandedOver& frame : stream.frames) {
    const int64_t stamp_ns = frame.observation.stamp_ns;
    if (stamp_ns < begin_ns) shown = &frame.observation;
    if (stamp_ns < begin_ns || stamp_ns >= end_ns || shown == nullptr) continue;
    Show(frame.observation, *shown);
    frame.shown_ns.reset();
  }
}

void Blacken(RecordedStream& stream, double percent, RandomStream& random) {
  for (HandedOver& frame : stream.frames) {
    if (random.Uniform() >= 0.01 * percent) continue;
    ForImages(frame.observation, [](Image& image) {  // a new picture: assigning an expression would write into the old
      image.pixels = cv::Mat(image.pixels.size(), image.pixels.type(), cv::Scalar::all(0));
    });
    frame.shown_ns.reset();
  }
}

/// Light times 2^stops, clipped at white.
void OverExpose(RecordedStream& stream, double stops, RandomStream&) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) {
    const double light = std::min(1.0, std::exp2(stops) * SrgbToLinear(i / 255.0));
    table.at<uchar>(i) = cv::saturate_cast<uchar>(255 * LinearToSrgb(light));
  }
  for (HandedOver& frame : stream.frames) {
    ForImages(frame.observation, [&](Image& image) {
      cv::Mat bright;
      cv::LUT(image.pixels, table, bright);
      image.pixels = bright;
    });
  }
}

/// By less than half the way to the nearer neighbour: stamps stay in order, as the interface of systems promises.
void JitterStamps(RecordedStream& stream, double percent, RandomStream& random) {
  std::vector<int64_t> stamps;
  for (const HandedOver& frame : stream.frames) stamps.push_back(frame.observation.stamp_ns);
  for (size_t i = 0; i < stamps.size(); ++i) {
    const double part = 0.01 * percent * random.Uniform(-0.5, 0.5);
    if (stamps.size() < 2) return;
    const int64_t before = i > 0 ? stamps[i] - stamps[i - 1] : stamps[1] - stamps[0];
    const int64_t after = i + 1 < stamps.size() ? stamps[i + 1] - stamps[i] : before;
    Restamp(stream.frames[i].observation, stamps[i] + std::llround(part * double(std::min(before, after))));
  }
}

/// A number for every tenth of a second, whatever the frames.
void SilenceImu(RecordedStream& stream, double percent, RandomStream& random) {
  constexpr int64_t kBlock_ns = 100'000'000;
  std::vector<double> blocks;
  std::optional<int64_t> first_ns;
  const auto is_lost = [&](const ImuSample& sample) {
    if (!first_ns) first_ns = sample.stamp_ns;
    const auto block = size_t(std::max<int64_t>(0, sample.stamp_ns - *first_ns) / kBlock_ns);
    while (blocks.size() <= block) blocks.push_back(random.Uniform());
    return blocks[block] < 0.01 * percent;
  };
  for (HandedOver& frame : stream.frames) std::erase_if(frame.observation.imu, is_lost);
}

/// Too long or too short, by the seed.
void MisstateFocalLength(RecordedStream& stream, double percent, RandomStream& random) {
  HandicapOptions options;
  options.focal_factor = 1 + (random.Uniform() < 0.5 ? -0.01 : 0.01) * percent;
  stream.calibration = FalsifiedCalibration(stream.calibration, options);
}

struct Entry {
  PerturbationInfo info;
  void (*apply)(RecordedStream&, double level, RandomStream&);
};

const std::vector<Entry>& Entries() {
  using Kind = PerturbationKind;
  static const std::vector<Entry> entries{
      {{Kind::kDropped, "% of the frames", 95, "frames never arrive; what other sensors read comes with the next"},
       &Drop},
      {{Kind::kDoubled, "% of the frames", 100, "frames arrive a second time, half-way to the next"}, &Double},
      {{Kind::kSwapped, "% of the frames", 100, "frames show each other's images, in pairs of neighbours"}, &Swap},
      {{Kind::kFrozen, "s", 2, "the image stands still for so long, once, from 40 to 60 % of the recording on"},
       &Freeze},
      {{Kind::kBlack, "% of the frames", 95, "images are black; depth is not"}, &Blacken},
      {{Kind::kOverExposed, "stops", 8, "all images are so much too bright, and clipped at white"}, &OverExpose},
      {{Kind::kStampJitter, "% of the frame interval", 95,
        "each stamp is wrong, evenly within an interval of that width; the order is kept"},
       &JitterStamps},
      {{Kind::kImuGaps, "% of the time", 100, "the IMU is silent for tenths of a second"}, &SilenceImu},
      {{Kind::kFocalLength, "%", 50, "the calibration's focal length is too long or too short, by the seed"},
       &MisstateFocalLength}};
  return entries;
}

}  // namespace

const std::vector<PerturbationInfo>& ListPerturbations() {
  static const std::vector<PerturbationInfo> infos = [] {
    std::vector<PerturbationInfo> list;
    for (const Entry& entry : Entries()) list.push_back(entry.info);
    return list;
  }();
  return infos;
}

const PerturbationInfo& InfoOf(PerturbationKind kind) { return ListPerturbations()[size_t(kind)]; }

bool HasStreamOf(PerturbationKind kind, const RecordedStream& stream) {
  const auto has_imu = [](const HandedOver& frame) { return !frame.observation.imu.empty(); };
  return kind != PerturbationKind::kImuGaps || std::any_of(stream.frames.begin(), stream.frames.end(), has_imu);
}

RecordedStream Perturbed(const RecordedStream& clean, PerturbationKind kind, double level, uint64_t seed) {
  GAITCAM_ASSERT(HasStreamOf(kind, clean));
  GAITCAM_ASSERT(level >= 0 && level <= InfoOf(kind).largest);
  RandomStream random(seed, "stress." + std::string(ToWord(kind)));
  RecordedStream stream = clean;
  Entries()[size_t(kind)].apply(stream, level, random);
  return stream;
}

}  // namespace gaitcam
