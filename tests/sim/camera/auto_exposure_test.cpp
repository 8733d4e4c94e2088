// Exposure and gain that follow the light; compression on the camera's link.

#include "sim/camera/auto_exposure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/camera/camera_rig.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

/// Mean of the image once the control has settled in a room of this luminance, and how it got there.
struct Settled {
  double mean = 0, exposure_ms = 0, gain = 0;
};

Settled Settle(const AutoExposureOptions& options, double luminance, int frames) {
  AutoExposure control(options, 10, 20);
  for (int i = 0; i < frames; ++i) control.Measure(luminance);
  return {luminance * control.gain() * control.exposure_ms() / 20, control.exposure_ms(), control.gain()};
}

TEST(AutoExposure, BringsTheMeanToItsTargetByTimeFirstAndThenByGain) {
  const AutoExposureOptions options;
  const Settled bright = Settle(options, 0.6, 40);
  EXPECT_NEAR(bright.mean, 0.18, 1e-6);
  EXPECT_NEAR(bright.exposure_ms, 6, 1e-3);
  EXPECT_EQ(bright.gain, 1);
  const Settled dim = Settle(options, 0.06, 40);  // a tenth of it: the time is spent, the rest is gain
  EXPECT_NEAR(dim.mean, 0.18, 1e-6);
  EXPECT_EQ(dim.exposure_ms, 30);
  EXPECT_NEAR(dim.gain, 2, 1e-3);
}

TEST(AutoExposure, AFrameTakesTheStatedPartOfTheErrorAway) {
  AutoExposureOptions options;
  options.speed = 0.25;
  AutoExposure control(options, 10, 20);
  const double before = control.exposure_ms();
  control.Measure(0.5);  // mean 0.25
  EXPECT_NEAR(control.exposure_ms() / before, std::pow(0.18 / 0.25, 0.25), 1e-12);
}

TEST(AutoExposure, StaysWithinItsLimitsInDarknessAndGlare) {
  const AutoExposureOptions options;
  const Settled dark = Settle(options, 0, 100), glare = Settle(options, 1e4, 100);
  EXPECT_EQ(dark.exposure_ms, options.max_ms);
  EXPECT_NEAR(dark.gain, options.max_gain, 1e-9);
  EXPECT_EQ(glare.exposure_ms, options.min_ms);
  EXPECT_EQ(glare.gain, 1);
  AutoExposure control(options, 10, 20);
  for (int i = 0; i < 100; ++i) control.Measure(0);
  for (int i = 0; i < 40; ++i) control.Measure(0.6);  // and comes back
  EXPECT_NEAR(control.exposure_ms(), 6, 1e-3);
}

CameraOptions SmallCmos() {
  CameraOptions options = CameraOptions::Of(CameraPreset::kCmos);
  options.width_px = 64;
  options.height_px = 48;
  options.pitch_deg = 0;
  return options;
}

struct Filmed {
  std::vector<double> exposures_ms;
  std::vector<cv::Mat> images;
  std::vector<int64_t> stamps_ns;
};

Filmed FilmRoom(const CameraOptions& options, double light_level, int frames, uint64_t seed = 1) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  Renderer renderer(model.get());
  const MotionRecord record = RecordFlight(
      model.get(),
      [](double) {
        return LookingAlongX({0, 0, 0.5});
      },
      0, 0.8);
  CameraRig rig(options, seed, light_level);
  Filmed filmed;
  for (int i = 0; i < frames; ++i) {
    LatentRigFrame latent = rig.Film(renderer, record, i, {false, false, false});
    filmed.exposures_ms.push_back(latent.exposure_ms);
    const RigFrame frame = rig.Develop(std::move(latent));
    filmed.images.push_back(frame.left.image.pixels);
    filmed.stamps_ns.push_back(frame.left.image.stamp_ns);
  }
  return filmed;
}

double MeanOf(const cv::Mat& image) { return cv::mean(image.reshape(1))[0]; }

TEST(AutoExposure, ADimRoomIsFilmedLongerAndAsBright) {
  constexpr int kFrames = 16;
  const Filmed bright = FilmRoom(SmallCmos(), 2, kFrames), dim = FilmRoom(SmallCmos(), 0.2, kFrames);
  EXPECT_GT(dim.exposures_ms.back(), 2 * bright.exposures_ms.back());
  EXPECT_LE(dim.exposures_ms.back(), 30);
  EXPECT_LT(MeanOf(dim.images.front()), 0.6 * MeanOf(bright.images.front()));
  EXPECT_NEAR(MeanOf(dim.images.back()), MeanOf(bright.images.back()), 0.05 * MeanOf(bright.images.back()));
  for (size_t i = 1; i < kFrames; ++i) {  // the stamps stay at the frame rate, to the rounding
    EXPECT_NEAR(double(bright.stamps_ns[i] - bright.stamps_ns[i - 1]), 1e9 / 30, 1);
  }
  EXPECT_EQ(bright.stamps_ns, dim.stamps_ns);
}

TEST(AutoExposure, TheSameWalkIsFilmedTheSame) {
  const Filmed one = FilmRoom(SmallCmos(), 0.4, 6), two = FilmRoom(SmallCmos(), 0.4, 6);
  EXPECT_EQ(one.exposures_ms, two.exposures_ms);
  for (size_t i = 0; i < one.images.size(); ++i) EXPECT_EQ(cv::norm(one.images[i], two.images[i], cv::NORM_INF), 0);
}

TEST(AutoExposure, ReseedingBeginsAnew) {
  EglContext gl;
  const MjModelPtr model = SpeckledRoom();
  Renderer renderer(model.get());
  const MotionRecord record = RecordFlight(
      model.get(),
      [](double) {
        return LookingAlongX({0, 0, 0.5});
      },
      0, 0.8);
  CameraRig rig(SmallCmos(), 1, 0.4);
  const double first_ms = rig.Film(renderer, record, 0, {false, false, false}).exposure_ms;
  rig.Film(renderer, record, 1, {false, false, false});
  EXPECT_NE(rig.Film(renderer, record, 2, {false, false, false}).exposure_ms, first_ms);
  rig.Reseed(1);
  EXPECT_EQ(rig.Film(renderer, record, 0, {false, false, false}).exposure_ms, first_ms);
}

TEST(AutoExposure, WhatDoesNotFitTheFramePeriodIsRefused) {
  CameraOptions options = SmallCmos();
  options.rate_hz = 40;
  try {
    CameraRig rig(options, 1);
    FAIL();
  } catch (const BadOption& e) {
    EXPECT_THAT(e.what(), HasSubstr("camera.auto_exposure.max_ms: 30"));
  }
  options = SmallCmos();
  options.auto_exposure->min_ms = 31;
  EXPECT_THROW(CameraRig(options, 1), BadOption);
}

TEST(CmosPreset, IsARollingShutterABarrelAndAutoExposure) {
  const CameraOptions cmos = CameraOptions::Of(CameraPreset::kCmos);
  EXPECT_GE(cmos.exposure.readout_ms, 15);
  EXPECT_LE(cmos.exposure.readout_ms, 25);
  EXPECT_LT(cmos.lens.k1, 0);
  EXPECT_TRUE(cmos.ExposesItself());
  EXPECT_FALSE(cmos.jpeg.has_value());
  CameraRig rig(cmos, 1);
  EXPECT_EQ(rig.MakeCalibration().readout_ms, 20);
}

TEST(Jpeg, TheSystemSeesWhatIsDecoded) {
  CameraOptions options = SmallCmos();
  const Filmed raw = FilmRoom(options, 1, 2);
  options.jpeg.emplace();
  const Filmed packed = FilmRoom(options, 1, 2), again = FilmRoom(options, 1, 2);
  options.jpeg->quality = 20;
  const Filmed coarse = FilmRoom(options, 1, 2);
  const auto difference = [&](const Filmed& other) {
    return cv::norm(raw.images[1], other.images[1], cv::NORM_L2) / std::sqrt(double(raw.images[1].total() * 3));
  };
  EXPECT_EQ(raw.exposures_ms, packed.exposures_ms);  // the meter sees the light, not the codes
  EXPECT_EQ(cv::norm(packed.images[1], again.images[1], cv::NORM_INF), 0);
  EXPECT_EQ(packed.images[1].type(), raw.images[1].type());
  EXPECT_GT(difference(packed), 0.5);  // grey levels, RMS: noise alone is some
  EXPECT_LT(difference(packed), 20);
  EXPECT_GT(difference(coarse), difference(packed));
}

TEST(Jpeg, GreyStaysGrey) {
  cv::Mat grey(32, 40, CV_8UC1);
  for (int i = 0; i < grey.rows * grey.cols; ++i) grey.data[i] = uint8_t(i * 7 % 251);
  const cv::Mat decoded = ThroughJpeg(grey, {});
  EXPECT_EQ(decoded.type(), CV_8UC1);
  EXPECT_EQ(decoded.size(), grey.size());
}

}  // namespace
}  // namespace gaitcam
