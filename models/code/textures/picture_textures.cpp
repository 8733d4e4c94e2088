#include "models/code/textures/picture_textures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "models/code/textures/texture_noise.h"
#include "models/code/textures/texture_paint.h"

namespace gaitcam {
namespace {

/// A random colour around `rgb`: brightness varies most, as in photographs.
cv::Scalar LeafColor(const Eigen::Vector3d& rgb, double contrast, RandomStream& random) {
  const double brightness = random.Uniform(-0.45, 0.45);
  Eigen::Vector3d color = rgb;
  for (int c = 0; c < 3; ++c) color[c] += contrast * (brightness + random.Normal(0, 0.08));
  return Bgr(color.cwiseMax(0.02).cwiseMin(0.98));
}

/// Covers `bgr` with leaves of radii from `min_radius` to `max_radius` px, the later ones in front.
void DropLeaves(cv::Mat& bgr, double min_radius, double max_radius, const Eigen::Vector3d& rgb, double contrast,
                RandomStream& random) {
  constexpr double kCover = 5;  // how many leaves lie over a point on average: e^-5 of it stays bare
  const double a = 1 / (min_radius * min_radius), b = 1 / (max_radius * max_radius);
  const double mean_area = 2 * M_PI * std::log(max_radius / min_radius) / (a - b);
  const double reach_x = bgr.cols + 2 * max_radius, reach_y = bgr.rows + 2 * max_radius;
  const int count = int(kCover * reach_x * reach_y / mean_area);
  for (int i = 0; i < count; ++i) {
    const double radius = 1 / std::sqrt(a - (a - b) * random.Uniform());  // inverse of the distribution of r^-3
    const cv::Point2d at(random.Uniform(0, reach_x) - max_radius, random.Uniform(0, reach_y) - max_radius);
    if (at.x < -radius || at.y < -radius || at.x > bgr.cols + radius || at.y > bgr.rows + radius) continue;
    FillDisc(bgr, at, radius, LeafColor(rgb, contrast, random));
  }
}

/// Adds 1/f noise of `amplitude` (part of white), the same to all colours.
void AddPinkNoise(cv::Mat& bgr, double amplitude, RandomStream& random) {
  const cv::Size grid(RoundUp(bgr.cols, 64), RoundUp(bgr.rows, 64));
  const cv::Mat noise = FractalNoise(grid, 64, 1, 1.0, random);
  for (int y = 0; y < bgr.rows; ++y) {
    const float* in = noise.ptr<float>(y);
    uint8_t* out = bgr.ptr<uint8_t>(y);
    for (int x = 0; x < bgr.cols; ++x, out += 3) {
      const int change = int(std::lround(255 * amplitude * in[x]));
      for (int c = 0; c < 3; ++c) out[c] = uint8_t(std::clamp(out[c] + change, 0, 255));
    }
  }
}

/// Draws into a part of a picture.
cv::Mat Part(cv::Mat& bgr, double left, double top, double width, double height) {
  const cv::Rect wanted(int(left * bgr.cols), int(top * bgr.rows), int(width * bgr.cols), int(height * bgr.rows));
  return bgr(wanted & cv::Rect({0, 0}, bgr.size()));
}

/// A photograph: dead leaves with a fine grain.
void PaintPhoto(cv::Mat part, const Eigen::Vector3d& rgb, double max_radius_px, double contrast, RandomStream& random) {
  part.setTo(Bgr(rgb));
  DropLeaves(part, 1.5, std::max(3.0, max_radius_px), rgb, contrast, random);
  AddPinkNoise(part, 0.03 * contrast, random);
}

/// A plot: axes, a few curves, and marks.
void PaintPlot(cv::Mat part, RandomStream& random) {
  part.setTo(cv::Scalar(250, 250, 250));
  const int w = part.cols, h = part.rows, left = w / 10, bottom = h * 9 / 10, thick = std::max(1, w / 150);
  cv::rectangle(part, {left, h / 20, w - left - w / 20, bottom - h / 20}, cv::Scalar(40, 40, 40), thick, cv::LINE_AA);
  for (int curve = 0; curve < 3; ++curve) {
    const cv::Scalar color = RandomColor(random, 0.2, 0.6);
    double value = random.Uniform(0.2, 0.8);
    cv::Point before;
    for (int k = 0; k <= 24; ++k) {
      value = std::clamp(value + random.Normal(0, 0.08), 0.05, 0.95);
      const cv::Point at(left + (w - left - w / 20) * k / 24, int(bottom - value * (bottom - h / 20)));
      if (k > 0) cv::line(part, before, at, color, thick, cv::LINE_AA);
      if (k % 4 == 0) cv::circle(part, at, 2 * thick + 1, color, cv::FILLED, cv::LINE_AA);
      before = at;
    }
  }
}

Eigen::Vector3d RandomMean(RandomStream& random) {
  const double value = random.Uniform(0.38, 0.62);
  return {value + random.Uniform(-0.12, 0.12), value + random.Uniform(-0.12, 0.12),
          value + random.Uniform(-0.12, 0.12)};
}

/// A conference poster or an advertisement, in `part`.
void PaintPoster(cv::Mat part, double px_per_m, double contrast, RandomStream& random) {
  const bool dark = random.Uniform() < 0.3;
  const cv::Scalar ground = dark ? RandomColor(random, 0.1, 0.3) : RandomColor(random, 0.78, 0.95);
  const cv::Scalar ink = dark ? RandomColor(random, 0.8, 0.95) : RandomColor(random, 0.05, 0.25);
  part.setTo(ground);
  cv::Mat header = Part(part, 0, 0, 1, 0.16);
  if (random.Uniform() < 0.6) header.setTo(RandomColor(random, 0.2, 0.6));
  DrawWords(part, {part.cols / 16, part.rows / 40, part.cols * 7 / 8, part.rows / 8}, part.rows * 0.055, ink, random);
  const int columns = part.cols > part.rows ? 3 : 2;
  const double width = 0.94 / columns;
  const double letter = std::max(3.0, 0.012 * px_per_m);
  for (int column = 0; column < columns; ++column) {
    for (double y = 0.19; y < 0.9;) {
      const double height = std::min(0.96 - y, random.Uniform(0.18, 0.4)), left = 0.03 + column * width;
      cv::Mat block = Part(part, left + 0.01, y, width - 0.02, height - 0.02);
      y += height;
      if (block.rows < 8 || block.cols < 8) continue;
      const double choice = random.Uniform();
      if (choice < 0.55) {
        PaintPhoto(block, RandomMean(random), 0.3 * block.cols, contrast, random);
      } else if (choice < 0.72) {
        PaintPlot(block, random);
      } else {
        DrawWords(block, {0, 0, block.cols, block.rows}, letter, ink, random);
      }
    }
  }
}

}  // namespace

cv::Mat MakeDeadLeaves(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3);
  PaintPhoto(bgr, o.rgb, o.unit_m * o.px_per_m, o.contrast, random);
  return bgr;
}

cv::Mat MakePink(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const cv::Size grid(RoundUp(size.width, 128), RoundUp(size.height, 128));
  const cv::Mat brightness = FractalNoise(grid, 128, 1, 1.0, random);
  std::vector<cv::Mat> planes(3);
  for (int c = 0; c < 3; ++c) {
    const cv::Mat hue = FractalNoise(grid, 128, 1, 1.0, random);
    cv::addWeighted(brightness, 0.17 * o.contrast * 255, hue, 0.06 * o.contrast * 255, 255 * o.rgb[2 - c], planes[c]);
    planes[c](cv::Rect({0, 0}, size)).convertTo(planes[c], CV_8U);
  }
  cv::Mat bgr;
  cv::merge(planes, bgr);
  return bgr;
}

cv::Mat MakePoster(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3);
  PaintPoster(bgr, o.px_per_m, o.contrast, random);
  if (random.Uniform() < 0.6) {  // a frame
    const int width = std::max(2, int(0.015 * o.px_per_m));
    cv::rectangle(bgr, {0, 0, size.width, size.height}, RandomColor(random, 0.05, 0.3), 2 * width);
  }
  AddPinkNoise(bgr, 0.015 * o.contrast, random);
  return bgr;
}

cv::Mat MakeNoticeBoard(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3);
  cv::Mat cork = FractalNoise({RoundUp(size.width, 8), RoundUp(size.height, 8)}, 8, 1, 0.9, random);
  cork = 1 + 0.14 * o.contrast * cork;
  Tint(cork(cv::Rect({0, 0}, size)), o.rgb).copyTo(bgr);
  const double px = o.px_per_m;
  const int sheets = std::max(3, int(14 * o.size_m.prod()));
  for (int i = 0; i < sheets; ++i) {
    const bool large = random.Uniform() < 0.5;
    const int w = int(px * (large ? 0.21 : random.Uniform(0.08, 0.15))), h = int(w * random.Uniform(0.7, 1.42));
    const int x = int(random.Uniform(0.02, 0.95) * (size.width - w)),
              y = int(random.Uniform(0.02, 0.95) * (size.height - h));
    if (w < 12 || h < 12 || w > size.width || h > size.height) continue;
    cv::Mat shadow = bgr(cv::Rect(x + 1, y + 1, w, h) & cv::Rect({0, 0}, size)), sheet = bgr(cv::Rect(x, y, w, h));
    shadow *= 0.6;
    if (random.Uniform() < 0.4) {
      PaintPoster(sheet, px, o.contrast, random);
    } else {
      sheet.setTo(RandomColor(random, 0.75, 0.92));
      DrawWords(sheet, {w / 10, h / 12, w * 8 / 10, h * 10 / 12}, std::max(3.0, 0.01 * px), {40, 40, 40}, random);
    }
    FillDisc(bgr, {x + w / 2.0, y + 0.008 * px}, std::max(1.2, 0.004 * px), RandomColor(random, 0.2, 0.8));
  }
  const int frame = std::max(2, int(0.02 * px));
  cv::rectangle(bgr, {0, 0, size.width, size.height}, cv::Scalar(150, 155, 158), 2 * frame);
  return bgr;
}

}  // namespace gaitcam
