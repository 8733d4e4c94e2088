#include "sim/camera/image_sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/camera/light.h"

namespace gaitcam {
namespace {

cv::Mat FlatLight(double level, int width = 320, int height = 240) {
  return cv::Mat(height, width, CV_32FC3, cv::Scalar::all(level));
}

struct Statistics {
  double mean = 0, variance = 0;
};

Statistics Measure(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image.reshape(1), mean, deviation);
  return {mean[0], deviation[0] * deviation[0]};
}

ExposureOptions LinearSensor() {
  ExposureOptions options;
  options.response = ResponseCurve::kLinear;
  options.exposure_ms = options.reference_exposure_ms;
  return options;
}

// Photon transfer: var(DN) = DN * 255 / full_well + (255 read / full_well)^2 + quantisation. Over levels, the slope of
// the variance over the mean is the conversion gain and the intercept is the read noise.
TEST(ImageSensor, NoiseFollowsThePhotonTransferLine) {
  ExposureOptions options = LinearSensor();
  options.full_well_e = 2000;
  options.read_noise_e = 20;
  const ImageSensor sensor(options, false);
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int i = 1; i <= 12; ++i) {
    const Statistics s = Measure(sensor.Develop(FlatLight(0.05 * i + 0.1), RandomStream(uint64_t(i), "sensor")));
    n += 1;
    sx += s.mean;
    sy += s.variance;
    sxx += s.mean * s.mean;
    sxy += s.mean * s.variance;
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx), intercept = (sy - slope * sx) / n;
  // 230,000 values per level give each variance to 0.3 %.
  EXPECT_NEAR(slope, 255.0 / 2000, 0.015 * 255.0 / 2000);
  EXPECT_NEAR(intercept, std::pow(255 * 20.0 / 2000, 2) + 1 / 12.0, 0.2);
}

TEST(ImageSensor, NoiseHasMeanZero) {
  const Statistics s = Measure(ImageSensor(LinearSensor(), false).Develop(FlatLight(0.4), RandomStream(1, "sensor")));
  EXPECT_NEAR(s.mean, 0.4 * 255, 0.01);  // standard error 0.004
}

TEST(ImageSensor, NoiseIsSpreadNormally) {
  ExposureOptions options = LinearSensor();
  options.full_well_e = 400;  // one standard deviation is many grey levels: rounding does not matter
  options.read_noise_e = 0;
  const cv::Mat image = ImageSensor(options, false).Develop(FlatLight(0.5), RandomStream(3, "sensor"));
  const double sigma = 255 * std::sqrt(200.0) / 400;
  int beyond_1 = 0, beyond_2 = 0, beyond_3 = 0;
  for (int i = 0; i < int(image.total()) * 3; ++i) {
    const double z = std::abs(image.data[i] - 127.5) / sigma;
    beyond_1 += z > 1;
    beyond_2 += z > 2;
    beyond_3 += z > 3;
  }
  const double count = double(image.total()) * 3;
  // Grey levels are 0.11 sigma wide, which blurs the thresholds by as much.
  EXPECT_NEAR(beyond_1 / count, 0.3173, 0.03);
  EXPECT_NEAR(beyond_2 / count, 0.0455, 0.008);
  EXPECT_NEAR(beyond_3 / count, 0.0027, 0.001);
}

TEST(ImageSensor, AutoGainKeepsBrightnessAndAmplifiesNoise) {
  ExposureOptions options = LinearSensor();
  const Statistics full = Measure(ImageSensor(options, false).Develop(FlatLight(0.5), RandomStream(1, "sensor")));
  options.exposure_ms = options.reference_exposure_ms / 10;
  const ImageSensor sensor(options, false);
  const Statistics tenth = Measure(sensor.Develop(FlatLight(0.5), RandomStream(1, "sensor")));
  EXPECT_NEAR(sensor.gain(), 10, 1e-9);
  EXPECT_NEAR(tenth.mean, full.mean, 0.05);
  // Shot noise alone: ten times fewer electrons, ten times the relative variance; read noise adds to the weak one.
  const double e = 500, expected = 255 * 255 * (e + 64) / 1e6;
  EXPECT_NEAR(tenth.variance, expected + 1 / 12.0, 0.03 * expected);
}

TEST(ImageSensor, ADimSceneIsAShortExposureToGainAndNoise) {
  ExposureOptions options = LinearSensor();
  const ImageSensor dim(options, false, 0.1);
  options.exposure_ms = options.reference_exposure_ms / 10;
  const ImageSensor brief(options, false);
  EXPECT_DOUBLE_EQ(dim.gain(), brief.gain());
  EXPECT_DOUBLE_EQ(dim.white_e(), brief.white_e());
  options = LinearSensor();
  options.gain = GainMode::kFixed;
  EXPECT_NEAR(Measure(ImageSensor(options, false, 0.1).DevelopNoiseless(FlatLight(0.8))).mean, 0.08 * 255, 0.5);
}

TEST(ImageSensor, FixedGainLetsBrightnessFollowTheExposure) {
  ExposureOptions options = LinearSensor();
  options.gain = GainMode::kFixed;
  options.exposure_ms = options.reference_exposure_ms / 4;
  EXPECT_NEAR(Measure(ImageSensor(options, false).DevelopNoiseless(FlatLight(0.8))).mean, 0.2 * 255, 0.5);
  options.exposure_ms = options.reference_exposure_ms * 4;
  EXPECT_EQ(Measure(ImageSensor(options, false).DevelopNoiseless(FlatLight(0.8))).mean, 255);  // the well is full
}

TEST(ImageSensor, AutoGainNeverAttenuates) {
  ExposureOptions options = LinearSensor();
  options.exposure_ms = 3 * options.reference_exposure_ms;
  const ImageSensor sensor(options, false);
  EXPECT_EQ(sensor.gain(), 1);
  EXPECT_EQ(sensor.white_e(), options.full_well_e);
}

TEST(ImageSensor, NoNoiseMeansNone) {
  ExposureOptions options;
  options.noise = 0;
  const ImageSensor sensor(options, false);
  EXPECT_EQ(Measure(sensor.Develop(FlatLight(0.3), RandomStream(1, "sensor"))).variance, 0);
}

TEST(ImageSensor, DisplayValuesComeBackThroughTheSrgbCurve) {
  const ImageSensor sensor(ExposureOptions(), false);
  for (int value = 0; value < 256; ++value) {
    EXPECT_EQ(sensor.DevelopNoiseless(FlatLight(SrgbToLinear(value / 255.0), 2, 2)).data[0], value);
  }
}

TEST(ImageSensor, GreyIsLuminanceWithNoiseOfItsOwn) {
  cv::Mat light(2, 2, CV_32FC3, cv::Scalar(0, 1, 0));  // pure green
  const ImageSensor sensor(LinearSensor(), true);
  const cv::Mat image = sensor.DevelopNoiseless(light);
  EXPECT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(image.data[0], std::lround(0.7152 * 255));
}

TEST(ImageSensor, SameStreamSameBytes) {
  const ImageSensor sensor(ExposureOptions(), false);
  const cv::Mat a = sensor.Develop(FlatLight(0.5), RandomStream(5, "x")),
                b = sensor.Develop(FlatLight(0.5), RandomStream(5, "x")),
                c = sensor.Develop(FlatLight(0.5), RandomStream(6, "x"));
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a, c, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gaitcam
