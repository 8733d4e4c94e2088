#include "models/code/textures/texture_noise.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {

cv::Mat WhiteNoise(cv::Size size, RandomStream& random) {
  cv::Mat field(size, CV_32FC1);
  constexpr float kScale = 3.4641016f / 65536.0f;  // sqrt(12): a uniform value of unit variance
  const size_t count = field.total();
  float* out = field.ptr<float>();
  for (size_t i = 0; i < count; i += 4) {
    uint64_t bits = random.Bits();
    for (size_t k = i; k < std::min(i + 4, count); ++k, bits >>= 16) {
      out[k] = (float(bits & 0xffff) - 32767.5f) * kScale;
    }
  }
  return field;
}

cv::Mat Enlarge(const cv::Mat& field, int across, int down) {
  constexpr int kPad = 2;  // what the bicubic kernel reaches
  const int pad_x = across > 1 ? kPad : 0, pad_y = down > 1 ? kPad : 0;
  cv::Mat padded, large;
  cv::copyMakeBorder(field, padded, pad_y, pad_y, pad_x, pad_x, cv::BORDER_WRAP | cv::BORDER_ISOLATED);
  cv::resize(padded, large, {padded.cols * across, padded.rows * down}, 0, 0, cv::INTER_CUBIC);
  return large({pad_x * across, pad_y * down, field.cols * across, field.rows * down});
}

cv::Mat FractalNoise(cv::Size size, int coarsest_px, int finest_px, double roughness, RandomStream& random) {
  GAITCAM_ASSERT(size.width % coarsest_px == 0 && size.height % coarsest_px == 0);
  cv::Mat field = WhiteNoise(size / coarsest_px, random);
  double amplitude = 1;
  for (int cell = coarsest_px; cell > finest_px; cell /= 2) {
    field = Enlarge(field, 2, 2);
    amplitude *= roughness;
    cv::scaleAdd(WhiteNoise(field.size(), random), amplitude, field, field);
  }
  if (finest_px > 1) field = Enlarge(field, finest_px, finest_px);
  Normalize(field);
  return field;
}

cv::Mat StreakNoise(cv::Size size, int length_px, RandomStream& random) {
  GAITCAM_ASSERT(size.width % (2 * length_px) == 0 && size.height % 4 == 0);
  cv::Mat fine = WhiteNoise({size.width / length_px, size.height}, random);
  const cv::Mat broad = Enlarge(WhiteNoise({size.width / (2 * length_px), size.height / 4}, random), 2, 4);
  cv::add(fine, broad, fine);
  // A streak one pixel wide would show as stairs wherever a camera looks along it from close by.
  const cv::Mat kernel = (cv::Mat_<float>(3, 1) << 0.25f, 0.5f, 0.25f);
  cv::Mat padded, soft;
  cv::copyMakeBorder(fine, padded, 1, 1, 0, 0, cv::BORDER_WRAP);
  cv::filter2D(padded, soft, CV_32F, kernel);
  cv::Mat field = Enlarge(soft.rowRange(1, size.height + 1), length_px, 1);
  Normalize(field);
  return field;
}

void Normalize(cv::Mat& field) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(field, mean, sigma);
  const double scale = sigma[0] > 0 ? 1 / sigma[0] : 1;
  field.convertTo(field, CV_32F, scale, -mean[0] * scale);
}

}  // namespace gaitcam
