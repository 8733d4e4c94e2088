#include "sim/camera/image_sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algorithms/core/errors.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

constexpr int kResponseSteps = 1 << 16;
constexpr int kNormals = 1 << 16;
constexpr float kConverterSteps = 4095;  // 12 bits
constexpr float kHalf = 0.5f;            // added before truncation, it rounds what is not negative

/// Means of the standard normal distribution over `count` equally likely intervals, then scaled to unit variance.
std::vector<float> MakeNormals(int count) {
  std::vector<double> normals(count);
  double x = 0;  // Newton's method on the distribution function from the middle outwards, each start from its neighbour
  for (int i = count / 2; i < count; ++i) {
    const double upper_tail = 1 - (i + 0.5) / count;
    for (int k = 0; k < 20; ++k) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
      const double step = (0.5 * std::erfc(x / std::numbers::sqrt2) - upper_tail) / density;
      x += step;
      if (std::abs(step) < 1e-13) break;
    }
    normals[i] = x;
    normals[count - 1 - i] = -x;
  }
  double squares = 0;
  for (const double value : normals) squares += value * value;
  std::vector<float> scaled(count);
  for (int i = 0; i < count; ++i) scaled[i] = float(normals[i] / std::sqrt(squares / count));
  return scaled;
}

std::vector<uint8_t> MakeResponse(ResponseCurve curve) {
  std::vector<uint8_t> codes(kResponseSteps + 1);
  for (int i = 0; i <= kResponseSteps; ++i) {
    const double linear = double(i) / kResponseSteps;
    codes[i] = uint8_t(std::lround(255 * (curve == ResponseCurve::kSrgb ? LinearToSrgb(linear) : linear)));
  }
  return codes;
}

/// `values.size()` numbers from the table, four of them per 64 random bits.
void Fill(std::vector<float>& values, const std::vector<float>& table, RandomStream& stream) {
  size_t i = 0;
  for (; i + 4 <= values.size(); i += 4) {
    const uint64_t bits = stream.Bits();
    values[i] = table[bits & 0xffff];
    values[i + 1] = table[(bits >> 16) & 0xffff];
    values[i + 2] = table[(bits >> 32) & 0xffff];
    values[i + 3] = table[bits >> 48];
  }
  for (uint64_t bits = stream.Bits(); i < values.size(); ++i, bits >>= 16) values[i] = table[bits & 0xffff];
}

}  // namespace

ImageSensor::ImageSensor(const ExposureOptions& options, bool grey, double light_level)
    : options_(options), grey_(grey), light_level_(light_level), response_(MakeResponse(options.response)) {
  CheckFields(options);
  const double share =
      light_level * (options.exposure_ms > 0 ? options.exposure_ms / options.reference_exposure_ms : 1);
  const bool automatic = options.gain == GainMode::kAuto;
  amplification_.white_e = options.full_well_e * (automatic ? std::min(1.0, share) : share);
  amplification_.gain = automatic ? options.full_well_e / amplification_.white_e : 1;
  if (options.noise > 0) normals_ = MakeNormals(kNormals);
}

Amplification ImageSensor::AmplificationAt(double exposure_ms, double gain) const {
  return {options_.full_well_e * light_level_ * exposure_ms / options_.reference_exposure_ms, gain};
}

cv::Mat ImageSensor::ToChannels(const cv::Mat& light) const {
  GAITCAM_ASSERT(light.type() == CV_32FC3);
  if (!grey_) return light;
  cv::Mat luminance;
  cv::transform(light, luminance, cv::Matx13f(0.0722f, 0.7152f, 0.2126f));  // Rec. 709, blue first
  return luminance;
}

cv::Mat ImageSensor::Develop(const cv::Mat& light, RandomStream noise, const Amplification& amplification) const {
  if (options_.noise == 0) return DevelopNoiseless(light, amplification);
  const cv::Mat channels = ToChannels(light);
  cv::Mat image(light.size(), CV_8UC(channels.channels()));
  const int count = channels.cols * channels.channels();
  const float white = float(amplification.white_e), factor = float(options_.noise), well = float(options_.full_well_e);
  const float read_variance = float(options_.read_noise_e * options_.read_noise_e);
  const float to_code = float(amplification.gain / options_.full_well_e) * kConverterSteps;
  const float to_step = kResponseSteps / kConverterSteps;
  std::vector<float> normal(count);
  std::vector<int> step(count);
  for (int row = 0; row < image.rows; ++row) {
    Fill(normal, normals_, noise);
    const float* from = channels.ptr<float>(row);
    for (int i = 0; i < count; ++i) {
      const float mean = std::max(from[i], 0.f) * white;
      const float electrons = mean + factor * std::sqrt(mean + read_variance) * normal[i];
      const float code = std::min(std::max(std::min(electrons, well), 0.f) * to_code, kConverterSteps);
      step[i] = int(float(int(code + kHalf)) * to_step + kHalf);
    }
    uint8_t* to = image.ptr<uint8_t>(row);
    for (int i = 0; i < count; ++i) to[i] = response_[step[i]];
  }
  return image;
}

cv::Mat ImageSensor::DevelopNoiseless(const cv::Mat& light, const Amplification& amplification) const {
  const cv::Mat channels = ToChannels(light);
  cv::Mat image(light.size(), CV_8UC(channels.channels()));
  const float white = float(amplification.white_e), well = float(options_.full_well_e);
  const float gain = float(amplification.gain);
  for (int row = 0; row < image.rows; ++row) {
    const float* from = channels.ptr<float>(row);
    uint8_t* to = image.ptr<uint8_t>(row);
    for (int i = 0; i < channels.cols * channels.channels(); ++i) {
      const float value = gain * std::clamp(from[i] * white, 0.f, well) / well;
      to[i] = response_[int(std::min(value, 1.f) * kResponseSteps + kHalf)];
    }
  }
  return image;
}

}  // namespace gaitcam
