#include "models/room_textures.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "models/texture_noise.h"
#include "models/texture_paint.h"

namespace gaitcam {
namespace {

/// Rows of words as they look from too far to read: letters are upright strokes of random height.
void DrawWords(cv::Mat& bgr, const cv::Rect& area, int letter_px, const cv::Scalar& color, RandomStream& random) {
  const int line = letter_px * 2;
  for (int y = area.y; y + letter_px <= area.br().y; y += line) {
    const int end = area.x + int(area.width * random.Uniform(0.6, 1.0));
    for (int x = area.x; x + letter_px < end;) {
      for (int letters = 2 + random.Index(7); letters > 0 && x + letter_px < end; --letters) {
        const int width = std::max(2, letter_px * (2 + random.Index(3)) / 5), stroke = std::max(1, letter_px / 5);
        const int top = random.Uniform() < 0.3 ? 0 : letter_px / 4;
        cv::rectangle(bgr, {x, y + top, stroke, letter_px - top}, color, cv::FILLED);
        if (random.Uniform() < 0.6) {
          const int bar = top + random.Index(std::max(1, letter_px - top));
          cv::rectangle(bgr, {x, y + bar, width, stroke}, color, cv::FILLED);
        }
        if (random.Uniform() < 0.5)
          cv::rectangle(bgr, {x + width - stroke, y + letter_px / 4, stroke, letter_px * 3 / 4}, color, cv::FILLED);
        x += width + stroke;
      }
      x += letter_px / 2;
    }
  }
}

cv::Scalar RandomColor(RandomStream& random, double low, double high) {
  const double value = random.Uniform(low, high);
  Eigen::Vector3d rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = value + random.Uniform(-0.18, 0.18);
  return Bgr(rgb.cwiseMax(0).cwiseMin(1));
}

}  // namespace

cv::Mat MakePaint(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const cv::Mat shading = Enlarge(FractalNoise(size / 16, 4, 1, 0.6, random), 16, 16);
  const cv::Mat roller = FractalNoise(size, 8, 1, 0.8, random);
  cv::Mat field;
  cv::addWeighted(shading, 0.02 * o.contrast, roller, 0.008 * o.contrast, 1.0, field);
  cv::Mat bgr = Tint(field, o.rgb);
  Wear wear(size);
  wear.AddSpots(int(4 * o.size_m.prod()), 0.002 * o.px_per_m, 0.006 * o.px_per_m, 0.12 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeWood(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const cv::Size turned(size.height, size.width);
  const cv::Mat streaks = StreakNoise(turned, 16, random);
  const cv::Mat warp = Enlarge(FractalNoise({turned.width / 64, turned.height / 16}, 4, 1, 0.5, random), 64, 16);
  const int rings = std::max(1, int(std::lround(o.size_m.x() / o.unit_m)));
  cv::Mat field(turned, CV_32FC1), upright;
  for (int y = 0; y < turned.height; ++y) {
    for (int x = 0; x < turned.width; ++x) {
      const float phase = float(y) * float(rings) / float(turned.height) + 1.6f * warp.at<float>(y, x);
      const float part = phase - std::floor(phase);
      const float tone = 0.1f - 0.24f * part * part + 0.035f * streaks.at<float>(y, x);
      field.at<float>(y, x) = 1 + float(o.contrast) * tone;
    }
  }
  cv::transpose(field, upright);
  cv::Mat bgr = Tint(upright, o.rgb);
  Wear wear(size);
  wear.AddScratches(int(6 * o.size_m.prod()), 0.02 * o.px_per_m, 0.15 * o.px_per_m, 0.25 * o.contrast, random);
  wear.AddSpots(int(12 * o.size_m.prod()), 0.0015 * o.px_per_m, 0.008 * o.px_per_m, 0.3 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeCardboard(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat field = FractalNoise(size, 16, 1, 0.8, random);
  for (int x = 0; x < size.width; ++x) {
    const double flute = 0.6 * std::sin(2 * M_PI * x / std::max(4.0, 0.008 * o.px_per_m));
    field.col(x) += flute;
  }
  field = 1 + 0.03 * o.contrast * field;
  cv::Mat bgr = Tint(field, o.rgb);
  const cv::Scalar ink = Bgr(0.35 * o.rgb);
  const int tape = size.height / 7, left = int(size.width * random.Uniform(0.06, 0.2));
  const cv::Rect strip(0, int(size.height * random.Uniform(0.05, 0.2)), size.width, tape);
  bgr(strip).convertTo(bgr(strip), -1, 0.85, 18);
  const cv::Rect label(left, int(size.height * 0.5), int(size.width * random.Uniform(0.3, 0.5)),
                       int(size.height * 0.38));
  cv::rectangle(bgr, label, cv::Scalar(235, 240, 240), cv::FILLED);
  const int letter = std::max(4, label.height / 9);
  DrawWords(bgr, {label.x + letter, label.y + letter, label.width - 2 * letter, label.height - 2 * letter}, letter,
            cv::Scalar(30, 30, 30), random);
  const int big = std::max(6, size.height / 9);
  const int start = label.br().x + big;
  DrawWords(bgr, {start, label.y, std::max(1, size.width - start - big / 2), label.height}, big, ink, random);
  return bgr;
}

cv::Mat MakeBooks(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3, cv::Scalar(26, 28, 30));
  const double px = o.px_per_m;
  double family = random.Uniform(0.2, 0.7);
  for (double x = 0; x < size.width - 3;) {
    const int width = int(std::min(size.width - x, std::max(5.0, px * o.unit_m * random.Uniform(0.4, 1.9))));
    const int height = int(size.height * random.Uniform(0.68, 0.99));
    if (random.Uniform() < 0.3) family = random.Uniform(0.15, 0.85);
    const cv::Rect spine(int(x), size.height - height, width - 1, height);
    const cv::Scalar cover = RandomColor(random, family - 0.1, family + 0.1);
    cv::rectangle(bgr, spine, cover, cv::FILLED);
    for (int i = 0; i < spine.width; ++i) {  // a spine is round: darker to its sides
      const double u = 2.0 * (i + 0.5) / spine.width - 1;
      bgr(cv::Rect(spine.x + i, spine.y, 1, spine.height)) *= 1 - 0.35 * u * u * u * u;
    }
    const cv::Scalar print = family < 0.5 ? RandomColor(random, 0.75, 0.95) : RandomColor(random, 0.05, 0.25);
    for (int bands = random.Index(3); bands > 0; --bands) {
      const int at = spine.y + int(spine.height * random.Uniform(0.05, 0.92));
      cv::rectangle(bgr, {spine.x, at, spine.width, std::max(1, int(0.006 * px))}, print, cv::FILLED);
    }
    if (spine.width >= 7) {  // the title runs along the spine
      const int letter = std::max(3, spine.width * 2 / 5), length = int(spine.height * random.Uniform(0.35, 0.6));
      cv::Mat title(letter, length, CV_8UC3, cover), turned;
      DrawWords(title, {0, 0, length, letter}, letter, print, random);
      cv::rotate(title, turned, cv::ROTATE_90_CLOCKWISE);
      const int top = spine.y + int((spine.height - length) * random.Uniform(0.2, 0.8));
      turned.copyTo(bgr(cv::Rect(spine.x + (spine.width - letter) / 2, top, letter, length)));
    }
    x += width;
  }
  return bgr;
}

}  // namespace gaitcam
