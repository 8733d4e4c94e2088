#include "models/code/textures/room_textures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "models/code/textures/texture_noise.h"
#include "models/code/textures/texture_paint.h"

namespace gaitcam {
cv::Mat MakePaint(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const cv::Mat shading = Enlarge(FractalNoise(size / 32, 8, 1, 0.35, random), 32, 32);
  const cv::Mat roller = FractalNoise(size, 8, 1, 0.8, random);
  cv::Mat field;
  cv::addWeighted(shading, 0.008 * o.contrast, roller, 0.008 * o.contrast, 1.0, field);
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
      const float tone = 0.13f * GrowthRing(phase) + 0.04f * streaks.at<float>(y, x);
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

cv::Mat MakeCloth(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const int fold = 1 << std::clamp(int(std::lround(std::log2(std::max(1.0, o.unit_m * o.px_per_m)))), 4, 7);
  const cv::Mat folds = Enlarge(FractalNoise(size / 8, fold / 8, 1, 0.45, random), 8, 8);
  const cv::Mat weft = StreakNoise(size, 16, random);
  cv::Mat warp;
  cv::transpose(StreakNoise({size.height, size.width}, 32, random), warp);
  const cv::Mat slubs = FractalNoise(size, 16, 2, 0.9, random);
  const cv::Mat field = 1 + o.contrast * (0.1 * folds + 0.05 * weft + 0.07 * warp + 0.05 * slubs);
  return Tint(field, o.rgb);
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
    if (spine.width >= 7 && spine.height >= 2 * spine.width) {  // the title runs along the spine
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

cv::Mat MakeDoor(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat grain = FractalNoise({RoundUp(size.width, 16), RoundUp(size.height, 16)}, 16, 1, 0.8, random);
  grain = 1 + 0.02 * o.contrast * grain;
  const Eigen::Vector3d leaf = o.rgb * random.Uniform(0.85, 1.1);
  cv::Mat bgr = Tint(grain, leaf.cwiseMin(1))(cv::Rect({0, 0}, size)).clone();
  const double px = o.px_per_m;
  const int frame = std::max(2, int(0.06 * px)), line = std::max(1, int(0.008 * px));
  cv::rectangle(bgr, {0, 0, size.width, size.height + frame}, Bgr({0.45, 0.46, 0.48}), 2 * frame);
  cv::rectangle(bgr, {frame, frame, size.width - 2 * frame, size.height}, Bgr({0.12, 0.12, 0.12}), line);
  const int inset = frame + size.width / 9;
  const bool window = random.Uniform() < 0.4;
  for (const auto& [top, bottom] : {std::pair(0.08, 0.42), std::pair(0.52, 0.93)}) {
    const cv::Rect panel(inset, int(top * size.height), size.width - 2 * inset, int((bottom - top) * size.height));
    if (window && top < 0.3) cv::rectangle(bgr, panel, Bgr({0.3, 0.36, 0.4}), cv::FILLED);
    cv::rectangle(bgr, panel, Bgr(0.6 * leaf), 2 * line);
    cv::rectangle(bgr, panel + cv::Point(line, line), Bgr((1.2 * leaf).cwiseMin(1)), line);
  }
  const int handle_x = frame + size.width / 14, handle_y = int(0.5 * size.height);
  cv::rectangle(bgr, {handle_x, handle_y, std::max(2, int(0.11 * px)), std::max(2, int(0.02 * px))},
                Bgr({0.8, 0.8, 0.82}), cv::FILLED);
  cv::circle(bgr, {handle_x, handle_y + int(0.09 * px)}, std::max(1, int(0.015 * px)), Bgr({0.1, 0.1, 0.1}), cv::FILLED,
             cv::LINE_AA);
  const cv::Rect sign(size.width / 2 - int(0.1 * px), int(0.445 * size.height), int(0.2 * px), int(0.1 * px));
  cv::rectangle(bgr, sign, cv::Scalar(235, 235, 235), cv::FILLED);
  DrawWords(bgr, {sign.x + 3, sign.y + 2, sign.width - 6, sign.height - 2}, 0.03 * px, cv::Scalar(40, 40, 40), random);
  Wear wear(size);
  wear.AddSpots(int(10 * o.size_m.prod()), 0.0015 * px, 0.006 * px, 0.25 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeCeiling(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat field = FractalNoise(size, 8, 1, 0.9, random);
  field = 1 + 0.015 * o.contrast * field;
  cv::Mat bgr = Tint(field, o.rgb);
  Wear holes(size);
  holes.AddSpots(int(150 * o.size_m.prod()), 0.0025 * o.px_per_m, 0.006 * o.px_per_m, 0.35 * o.contrast, random);
  holes.ApplyTo(bgr);
  const int columns = std::clamp(int(std::lround(o.size_m.x() / o.unit_m)), 1, size.width / 8);
  const int rows = std::clamp(int(std::lround(o.size_m.y() / o.unit_m)), 1, size.height / 8);
  const int rail = std::max(1, int(0.02 * o.px_per_m));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const cv::Point from(i * size.width / columns, j * size.height / rows);
      const cv::Rect panel(from, cv::Point((i + 1) * size.width / columns, (j + 1) * size.height / rows));
      if (i % 3 == 1 && j % 3 == 1) bgr(panel).setTo(cv::Scalar(249, 251, 251));  // a lamp
      cv::rectangle(bgr, {from.x, from.y, panel.width, rail}, Bgr(0.72 * o.rgb), cv::FILLED);
      cv::rectangle(bgr, {from.x, from.y, rail, panel.height}, Bgr(0.78 * o.rgb), cv::FILLED);
    }
  }
  return bgr;
}

}  // namespace gaitcam
