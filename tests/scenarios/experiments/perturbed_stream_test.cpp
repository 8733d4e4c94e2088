// Perturbations as properties: what a level does is repeatable, contained in what a higher one does, and honest about
// what each image shows.

#include "scenarios/code/experiments/perturbed_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>

#include "algorithms/core/random.h"
#include "algorithms/core/units.h"

namespace gaitcam {
namespace {

using Kind = PerturbationKind;

constexpr int kFrames = 120;
constexpr int64_t kStart_ns = 1'700'000'000'000'000'000, kFrame_ns = 50'000'000, kImu_ns = 4'000'000;

Image NoiseImage(int64_t stamp_ns, RandomStream& random) {
  cv::Mat pixels(6, 8, CV_8UC3);
  for (size_t i = 0; i < pixels.total() * 3; ++i) pixels.data[i] = uchar(random.Index(256));
  return {stamp_ns, pixels};
}

/// Stereo with depth and all readings; every byte of every image is drawn.
RecordedStream CleanStream(bool has_imu = true) {
  RandomStream random(1, "stream");
  RecordedStream stream;
  stream.calibration.camera = CameraModel::FromHorizontalFov(8, 6, 60);
  stream.calibration.right = stream.calibration.camera;
  for (int64_t i = 0, imu_ns = kStart_ns; i < kFrames; ++i) {
    HandedOver frame;
    Observation& o = frame.observation;
    o.stamp_ns = kStart_ns + i * kFrame_ns;
    o.exposure_ms = 10;
    o.image = NoiseImage(o.stamp_ns, random);
    o.right = NoiseImage(o.stamp_ns, random);
    o.depth = Image{o.stamp_ns, cv::Mat(6, 8, CV_32FC1, cv::Scalar(1 + double(i)))};
    for (; imu_ns <= o.stamp_ns + std::llround(0.5 * kNsPerMs * o.exposure_ms); imu_ns += kImu_ns) {
      if (has_imu) o.imu.push_back({imu_ns, {random.Normal(), 0, 0}, {0, 0, 9.8}});
      o.joints.push_back({imu_ns, {random.Normal()}, true, false});
      o.odometry.push_back({imu_ns, {random.Normal(), 0}, 0});
    }
    frame.shown_ns = o.stamp_ns;
    stream.frames.push_back(std::move(frame));
  }
  return stream;
}

std::string BytesOf(const cv::Mat& mat) {
  return std::string(reinterpret_cast<const char*>(mat.data), mat.total() * mat.elemSize());
}
std::string BytesOf(const Image& image) { return std::to_string(image.stamp_ns) + ":" + BytesOf(image.pixels); }

/// All that a system is told, as text.
std::string BytesOf(const RecordedStream& stream) {
  std::string text;
  const auto add = [&](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  for (const CameraModel& camera : {stream.calibration.camera, *stream.calibration.right}) {
    for (const double number : {camera.fx, camera.fy, camera.cx, camera.cy}) add(number);
  }
  for (const HandedOver& frame : stream.frames) {
    const Observation& o = frame.observation;
    add(o.stamp_ns);
    add(o.exposure_ms);
    add(frame.shown_ns.value_or(-1));
    text += BytesOf(o.image) + BytesOf(*o.right) + BytesOf(*o.depth);
    for (const ImuSample& sample : o.imu) {
      add(sample.stamp_ns);
      add(sample.angular_rate.x());
    }
    for (const JointSample& sample : o.joints) {
      add(sample.stamp_ns);
      add(sample.position.front());
    }
    for (const OdometrySample& sample : o.odometry) {
      add(sample.stamp_ns);
      add(sample.position.x());
    }
  }
  return text;
}

const Observation& TakenAt(const RecordedStream& stream, int64_t stamp_ns) {
  return stream.frames.at(size_t((stamp_ns - kStart_ns) / kFrame_ns)).observation;
}

std::vector<int64_t> ImuStamps(const RecordedStream& stream) {
  std::vector<int64_t> stamps;
  for (const HandedOver& frame : stream.frames)
    for (const ImuSample& sample : frame.observation.imu) stamps.push_back(sample.stamp_ns);
  return stamps;
}

/// What differs from the clean stream: frames missing or put in, images, readings missing; each by its stamp.
std::set<std::string> TracesOf(const RecordedStream& clean, const RecordedStream& stream) {
  std::set<std::string> traces;
  std::map<int64_t, std::string> images;
  for (const HandedOver& frame : stream.frames)
    images[frame.observation.stamp_ns] = BytesOf(frame.observation.image.pixels);
  for (const HandedOver& frame : clean.frames) {
    const std::string stamp = std::to_string(frame.observation.stamp_ns);
    const auto at = images.find(frame.observation.stamp_ns);
    if (at == images.end()) {
      traces.insert("missing " + stamp);
    } else {
      if (at->second != BytesOf(frame.observation.image.pixels)) traces.insert("image " + stamp);
      images.erase(at);
    }
  }
  for (const auto& [stamp_ns, image] : images) traces.insert("put in " + std::to_string(stamp_ns));
  const std::vector<int64_t> readings = ImuStamps(stream);
  const std::set<int64_t> kept(readings.begin(), readings.end());
  if (!stream.frames.empty() && stream.frames.back().observation.stamp_ns >= clean.frames.back().observation.stamp_ns)
    for (const int64_t stamp_ns : ImuStamps(clean))
      if (kept.count(stamp_ns) == 0) traces.insert("silent " + std::to_string(stamp_ns));
  return traces;
}

bool LosesImages(Kind kind) { return kind == Kind::kDropped || kind == Kind::kFrozen || kind == Kind::kBlack; }

class PerturbedStream : public testing::Test {
 protected:
  const RecordedStream clean_ = CleanStream();
  const std::string clean_bytes_ = BytesOf(clean_);
};

TEST_F(PerturbedStream, TheTableOfKindsIsInTheOrderOfTheirWords) {
  ASSERT_EQ(ListPerturbations().size(), WordsOf(Kind()).size());
  for (const auto& entry : WordsOf(Kind())) EXPECT_EQ(InfoOf(entry.value).kind, entry.value) << entry.word;
}

TEST_F(PerturbedStream, LevelZeroChangesNotAByte) {
  for (const PerturbationInfo& info : ListPerturbations())
    for (const uint64_t seed : {1, 2, 3})
      EXPECT_TRUE(BytesOf(Perturbed(clean_, info.kind, 0, seed)) == clean_bytes_) << ToWord(info.kind);
}

TEST_F(PerturbedStream, TheSameSeedGivesTheSameBytesAndAnotherOnesOthers) {
  for (const PerturbationInfo& info : ListPerturbations()) {
    const double level = info.largest / 2;
    const std::string first = BytesOf(Perturbed(clean_, info.kind, level, 1));
    EXPECT_TRUE(first != clean_bytes_) << ToWord(info.kind);
    EXPECT_TRUE(first == BytesOf(Perturbed(clean_, info.kind, level, 1))) << ToWord(info.kind);
    std::set<std::string> all;
    for (uint64_t seed = 1; seed <= 8; ++seed) all.insert(BytesOf(Perturbed(clean_, info.kind, level, seed)));
    // Too bright is too bright; a focal length is too long or too short; of 8 freezes, which begin at one of 24 frames
    // each, some may agree.
    const size_t least = info.kind == Kind::kOverExposed ? 1 : info.kind == Kind::kFocalLength ? 2 : 5;
    const size_t most = least < 5 ? least : 8;
    EXPECT_GE(all.size(), least) << ToWord(info.kind);
    EXPECT_LE(all.size(), most) << ToWord(info.kind);
  }
}

TEST_F(PerturbedStream, TheRecordingItselfStaysAsItIsThoughImagesAreShared) {
  for (const PerturbationInfo& info : ListPerturbations()) Perturbed(clean_, info.kind, info.largest, 1);
  EXPECT_TRUE(BytesOf(clean_) == clean_bytes_);
}

TEST_F(PerturbedStream, WhatALevelDoesAHigherOneDoesToo) {
  for (const Kind kind : {Kind::kDropped, Kind::kDoubled, Kind::kSwapped, Kind::kFrozen, Kind::kBlack, Kind::kImuGaps})
    for (const uint64_t seed : {1, 2, 3}) {
      std::set<std::string> lower;
      for (int step = 1; step <= 16; ++step) {
        const double level = InfoOf(kind).largest * step / 16;
        const std::set<std::string> traces = TracesOf(clean_, Perturbed(clean_, kind, level, seed));
        EXPECT_TRUE(std::includes(traces.begin(), traces.end(), lower.begin(), lower.end()))
            << ToWord(kind) << " " << level;
        lower = traces;
      }
      EXPECT_GT(lower.size(), 30U) << ToWord(kind);  // 2 s of 20 Hz, the least of them
    }
}

TEST_F(PerturbedStream, ALevelIsTheShareThatItSays) {
  // 120 draws of 30 %: mean 36, standard deviation 5; of 60 pairs, 18 and 3.5, which are two frames each.
  const auto count = [&](Kind kind) { return int(TracesOf(clean_, Perturbed(clean_, kind, 30, 1)).size()); };
  EXPECT_NEAR(count(Kind::kDropped), 36, 15);
  EXPECT_NEAR(count(Kind::kDoubled), 36, 15);
  EXPECT_NEAR(count(Kind::kBlack), 36, 15);
  EXPECT_NEAR(count(Kind::kSwapped), 36, 21);
  const auto& frozen = TracesOf(clean_, Perturbed(clean_, Kind::kFrozen, 1.5, 1));
  EXPECT_NEAR(double(frozen.size()), 30, 1);
  EXPECT_TRUE(ImuStamps(Perturbed(clean_, Kind::kImuGaps, 100, 1)).empty());
  EXPECT_EQ(Perturbed(clean_, Kind::kDoubled, 100, 1).frames.size(), size_t(2 * kFrames - 1));
}

TEST_F(PerturbedStream, BrighterClipsMoreAndJitterAndFocalLengthGrowInProportion) {
  const auto white = [&](double stops) {
    const RecordedStream bright = Perturbed(clean_, Kind::kOverExposed, stops, 1);
    int sum = 0;
    for (const HandedOver& frame : bright.frames) {
      const std::string bytes = BytesOf(frame.observation.image.pixels);
      sum += int(std::count(bytes.begin(), bytes.end(), char(-1)));
    }
    return sum;
  };
  // A stop more: what was above half the light, 188 of 255 (sRGB), is white. Bytes are even: 68 of 256.
  const double bytes = 8.0 * 6 * 3 * kFrames;
  EXPECT_NEAR(white(1) / bytes, 68 / 256.0, 0.02);
  EXPECT_LT(white(1), white(2));
  EXPECT_LT(white(2), white(4));
  const RecordedStream some = Perturbed(clean_, Kind::kStampJitter, 40, 1),
                       more = Perturbed(clean_, Kind::kStampJitter, 80, 1);
  double widest = 0;
  for (size_t i = 0; i < clean_.frames.size(); ++i) {
    const int64_t stamp_ns = clean_.frames[i].observation.stamp_ns;
    const auto by_some = double(some.frames[i].observation.stamp_ns - stamp_ns);
    EXPECT_NEAR(2 * by_some, double(more.frames[i].observation.stamp_ns - stamp_ns), 2);  // rounded to ns
    EXPECT_EQ(some.frames[i].observation.image.stamp_ns, some.frames[i].observation.stamp_ns);
    widest = std::max(widest, std::abs(by_some));
  }
  EXPECT_LE(widest, 0.2 * kFrame_ns);
  EXPECT_GT(widest, 0.15 * kFrame_ns);
  const double factor =
      Perturbed(clean_, Kind::kFocalLength, 10, 1).calibration.camera.fx / clean_.calibration.camera.fx;
  EXPECT_NEAR(std::abs(factor - 1), 0.1, 1e-12);
  const Calibration twice = Perturbed(clean_, Kind::kFocalLength, 20, 1).calibration;
  EXPECT_NEAR(twice.camera.fx / clean_.calibration.camera.fx - 1, 2 * (factor - 1), 1e-12);
  EXPECT_NEAR(twice.right->fy / clean_.calibration.right->fy - 1, 2 * (factor - 1), 1e-12);
}

TEST_F(PerturbedStream, StampsIncreaseAndNoReadingIsLostOrComesLate) {
  const std::vector<int64_t> readings = ImuStamps(clean_);
  for (const PerturbationInfo& info : ListPerturbations())
    for (const double part : {0.25, 0.5, 1.0})
      for (const uint64_t seed : {1, 2, 3}) {
        const RecordedStream stream = Perturbed(clean_, info.kind, part * info.largest, seed);
        for (size_t i = 1; i < stream.frames.size(); ++i) {
          EXPECT_LT(stream.frames[i - 1].observation.stamp_ns, stream.frames[i].observation.stamp_ns)
              << ToWord(info.kind);
        }
        if (info.kind == Kind::kImuGaps) continue;
        const std::vector<int64_t> given = ImuStamps(stream);
        ASSERT_LE(given.size(), readings.size());
        EXPECT_TRUE(std::equal(given.begin(), given.end(), readings.begin())) << ToWord(info.kind);
        // After the last frame that arrives nothing can: of dropped ones alone, readings are missing.
        EXPECT_TRUE(info.kind == Kind::kDropped || given.size() == readings.size()) << ToWord(info.kind);
        if (info.kind == Kind::kStampJitter) continue;  // the frames' clock is wrong, the readings' is not
        for (const HandedOver& frame : stream.frames) {
          const Observation& o = frame.observation;
          const int64_t close_ns = o.stamp_ns + std::llround(0.5 * kNsPerMs * o.exposure_ms);
          if (o.imu.empty()) continue;
          EXPECT_LE(o.imu.back().stamp_ns, close_ns) << ToWord(info.kind);
          // Whatever there is to have has arrived: the next reading is after the shutter's close.
          const auto next = std::upper_bound(readings.begin(), readings.end(), close_ns);
          EXPECT_TRUE(next == readings.end() || *next - o.imu.back().stamp_ns == kImu_ns) << ToWord(info.kind);
        }
      }
}

TEST_F(PerturbedStream, SaysWhenEachImageWasTrulyTakenAndCountsNoneTwice) {
  for (const PerturbationInfo& info : ListPerturbations()) {
    if (info.kind == Kind::kOverExposed) continue;
    const RecordedStream stream = Perturbed(clean_, info.kind, 0.6 * info.largest, 2);
    std::set<int64_t> shown;
    for (const HandedOver& frame : stream.frames) {
      const Observation& o = frame.observation;
      EXPECT_EQ(o.image.stamp_ns, o.stamp_ns);
      EXPECT_EQ(o.right->stamp_ns, o.stamp_ns);
      EXPECT_EQ(o.depth->stamp_ns, o.stamp_ns);
      if (!frame.shown_ns) continue;
      EXPECT_TRUE(shown.insert(*frame.shown_ns).second) << ToWord(info.kind);
      const Observation& taken = TakenAt(clean_, *frame.shown_ns);
      EXPECT_EQ(BytesOf(o.image.pixels), BytesOf(taken.image.pixels)) << ToWord(info.kind);
      EXPECT_EQ(BytesOf(o.right->pixels), BytesOf(taken.right->pixels)) << ToWord(info.kind);
      EXPECT_EQ(BytesOf(o.depth->pixels), BytesOf(taken.depth->pixels)) << ToWord(info.kind);
    }
    EXPECT_EQ(shown.size() < size_t(kFrames), LosesImages(info.kind)) << ToWord(info.kind);
  }
}

TEST_F(PerturbedStream, RepeatsShowWhatWasShownBefore) {
  for (const Kind kind : {Kind::kDoubled, Kind::kFrozen}) {
    const RecordedStream stream = Perturbed(clean_, kind, 0.6 * InfoOf(kind).largest, 2);
    for (size_t i = 1; i < stream.frames.size(); ++i) {
      if (stream.frames[i].shown_ns) continue;
      EXPECT_EQ(BytesOf(stream.frames[i].observation.image.pixels),
                BytesOf(stream.frames[i - 1].observation.image.pixels));
    }
  }
}

TEST_F(PerturbedStream, GapsOfAnImuNeedOne) {
  const RecordedStream without = CleanStream(false);
  for (const PerturbationInfo& info : ListPerturbations()) {
    EXPECT_TRUE(HasStreamOf(info.kind, clean_));
    EXPECT_EQ(HasStreamOf(info.kind, without), info.kind != Kind::kImuGaps);
  }
}

TEST_F(PerturbedStream, ARecordingWithoutFramesStaysEmpty) {
  RecordedStream empty = clean_;
  empty.frames.clear();
  for (const PerturbationInfo& info : ListPerturbations()) {
    if (!HasStreamOf(info.kind, empty)) continue;
    EXPECT_TRUE(Perturbed(empty, info.kind, info.largest, 1).frames.empty()) << ToWord(info.kind);
  }
}

}  // namespace
}  // namespace gaitcam
