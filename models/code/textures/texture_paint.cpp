#include "models/code/textures/texture_paint.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace gaitcam {
namespace {

constexpr int kShift = 4;  // fractional bits of the drawing functions' coordinates
constexpr double kOne = 1 << kShift;

/// Calls `draw` with every shift by whole sizes at which something of extent `reach` at `at` shows.
template <class Draw>
void ForWrappedCopies(cv::Size size, cv::Point2d at, double reach, Draw draw) {
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const cv::Point2d shift(i * size.width, j * size.height), p = at + shift;
      if (p.x < -reach || p.y < -reach || p.x > size.width + reach || p.y > size.height + reach) continue;
      draw(shift);
    }
  }
}

cv::Point Fixed(cv::Point2d p) { return {int(std::lround(p.x * kOne)), int(std::lround(p.y * kOne))}; }

}  // namespace

cv::Scalar Bgr(const Eigen::Vector3d& rgb) { return {255 * rgb.z(), 255 * rgb.y(), 255 * rgb.x()}; }

cv::Mat Tint(const cv::Mat& factor, const Eigen::Vector3d& rgb) {
  cv::Mat bgr(factor.size(), CV_8UC3);
  const float b = float(255 * rgb.z()), g = float(255 * rgb.y()), r = float(255 * rgb.x());
  for (int y = 0; y < factor.rows; ++y) {
    const float* in = factor.ptr<float>(y);
    uint8_t* out = bgr.ptr<uint8_t>(y);
    for (int x = 0; x < factor.cols; ++x, out += 3) {
      const float f = std::max(0.0f, in[x]);
      out[0] = uint8_t(std::min(255.0f, f * b + 0.5f));
      out[1] = uint8_t(std::min(255.0f, f * g + 0.5f));
      out[2] = uint8_t(std::min(255.0f, f * r + 0.5f));
    }
  }
  return bgr;
}

void FillDisc(cv::Mat& bgr, cv::Point2d center, double radius, const cv::Scalar& color) {
  const uint8_t paint[3] = {uint8_t(color[0]), uint8_t(color[1]), uint8_t(color[2])};
  const double outer = radius + 0.5, inner = std::max(0.0, radius - 0.5);
  const int top = std::max(0, int(std::ceil(center.y - outer)));
  const int bottom = std::min(bgr.rows - 1, int(std::floor(center.y + outer)));
  for (int y = top; y <= bottom; ++y) {
    const double dy2 = (y - center.y) * (y - center.y);
    const double reach = std::sqrt(std::max(0.0, outer * outer - dy2));
    const double full = dy2 < inner * inner ? std::sqrt(inner * inner - dy2) : -1;
    const int left = std::max(0, int(std::ceil(center.x - reach)));
    const int right = std::min(bgr.cols - 1, int(std::floor(center.x + reach)));
    uint8_t* out = bgr.ptr<uint8_t>(y) + 3 * left;
    for (int x = left; x <= right; ++x, out += 3) {
      const double dx = x - center.x;
      if (std::abs(dx) <= full) {
        for (int c = 0; c < 3; ++c) out[c] = paint[c];
        continue;
      }
      // Coverage of a pixel at the rim, by its distance from it; a disc smaller than a pixel covers its area at most.
      double cover = std::clamp(outer - std::sqrt(dx * dx + dy2), 0.0, 1.0);
      cover = std::min(cover, M_PI * radius * radius);
      for (int c = 0; c < 3; ++c) out[c] = uint8_t(out[c] + cover * (paint[c] - out[c]) + 0.5);
    }
  }
}

void DrawWords(cv::Mat& bgr, const cv::Rect& area, double letter_px, const cv::Scalar& color, RandomStream& random) {
  static const std::string kVowels = "aeiou", kConsonants = "bcdfghklmnprstvw";
  constexpr double kFontHeight = 21;  // px of a capital of Hershey's simplex font at scale 1
  const double scale = letter_px / kFontHeight;
  const int thick = std::max(1, int(std::lround(letter_px / 7)));
  cv::Mat inside = bgr(area & cv::Rect({0, 0}, bgr.size()));
  for (double base = letter_px; base <= area.height; base += 1.7 * letter_px) {
    const double end = area.width * random.Uniform(0.55, 1.0);
    for (double x = 0; x < end;) {
      std::string word;
      for (int syllables = 1 + random.Index(4); syllables > 0; --syllables) {
        word += kConsonants[random.Index(int(kConsonants.size()))];
        word += kVowels[random.Index(int(kVowels.size()))];
      }
      if (random.Uniform() < 0.25) word[0] = char(word[0] - 'a' + 'A');
      double width = cv::getTextSize(word, cv::FONT_HERSHEY_SIMPLEX, scale, thick, nullptr).width;
      if (x == 0 && width > area.width) {  // a narrow column has at least a part of a word in each line
        word.resize(std::max<size_t>(1, size_t(word.size() * area.width / width)));
        width = area.width;
      }
      if (x + width > area.width) break;
      cv::putText(inside, word, {int(x), int(base)}, cv::FONT_HERSHEY_SIMPLEX, scale, color, thick, cv::LINE_AA);
      x += width + 0.6 * letter_px;
    }
  }
}

cv::Scalar RandomColor(RandomStream& random, double low, double high) {
  const double value = random.Uniform(low, high);
  Eigen::Vector3d rgb;
  for (int c = 0; c < 3; ++c) rgb[c] = value + random.Uniform(-0.13, 0.13);
  return Bgr(rgb.cwiseMax(0).cwiseMin(1));
}

namespace {

/// A level of the layer that is lighter or darker by up to `strength`.
double RandomLevel(double strength, RandomStream& random) {
  const double change = strength * random.Uniform(0.3, 1.0);
  return 128 * (random.Uniform() < 0.5 ? 1 + change : 1 - change);
}

}  // namespace

Wear::Wear(cv::Size size) : layer_(size, CV_8UC1, cv::Scalar(128)) {}

void Wear::AddSpots(int count, double min_radius_px, double max_radius_px, double strength, RandomStream& random) {
  for (int i = 0; i < count; ++i) {
    const cv::Point2d at(random.Uniform(0, layer_.cols), random.Uniform(0, layer_.rows));
    const double u = random.Uniform();  // many small, few large
    const double radius = min_radius_px * std::pow(max_radius_px / min_radius_px, u * u);
    const double level = RandomLevel(strength, random), angle = random.Uniform(0, 2 * M_PI);
    std::vector<cv::Point> outline;
    constexpr int kCorners = 8;
    for (int k = 0; k < kCorners; ++k) {
      const double a = angle + 2 * M_PI * k / kCorners, r = radius * random.Uniform(0.7, 1.2);
      outline.push_back(Fixed(at + r * cv::Point2d(std::cos(a), 0.8 * std::sin(a))));
    }
    ForWrappedCopies(layer_.size(), at, 1.2 * radius + 1, [&](cv::Point2d shift) {
      std::vector<cv::Point> copy = outline;
      for (cv::Point& p : copy) p += Fixed(shift);
      cv::fillConvexPoly(layer_, copy, cv::Scalar(level), cv::LINE_AA, kShift);
    });
  }
}

void Wear::DrawPath(const std::vector<cv::Point2d>& points, double level) {
  double reach = 2;
  for (const cv::Point2d& p : points) reach = std::max(reach, 2 + cv::norm(p - points[0]));
  ForWrappedCopies(layer_.size(), points[0], reach, [&](cv::Point2d shift) {
    for (size_t k = 1; k < points.size(); ++k) {
      cv::line(layer_, Fixed(points[k - 1] + shift), Fixed(points[k] + shift), cv::Scalar(level), 1, cv::LINE_AA,
               kShift);
    }
  });
}

void Wear::AddScratches(int count, double min_length_px, double max_length_px, double strength, RandomStream& random) {
  constexpr int kPieces = 6;
  for (int i = 0; i < count; ++i) {
    std::vector<cv::Point2d> points{{random.Uniform(0, layer_.cols), random.Uniform(0, layer_.rows)}};
    const double piece = random.Uniform(min_length_px, max_length_px) / kPieces, bend = random.Normal(0, 0.6);
    double angle = random.Uniform(0, 2 * M_PI);
    for (int k = 0; k < kPieces; ++k) {
      points.push_back(points.back() + piece * cv::Point2d(std::cos(angle), std::sin(angle)));
      angle += bend / kPieces + random.Normal(0, 0.1);
    }
    DrawPath(points, RandomLevel(strength, random));
  }
}

void Wear::AddCracks(int count, double length_px, double strength, RandomStream& random) {
  constexpr double kPiece = 5;  // px
  for (int i = 0; i < count; ++i) {
    std::vector<cv::Point2d> starts{{random.Uniform(0, layer_.cols), random.Uniform(0, layer_.rows)}};
    double heading = random.Uniform(0, 2 * M_PI), left = length_px * random.Uniform(0.4, 1.0);
    for (size_t branch = 0; branch < starts.size(); ++branch) {
      std::vector<cv::Point2d> points{starts[branch]};
      for (double gone = 0; gone < left; gone += kPiece) {
        const double angle = heading + random.Normal(0, 0.5);
        heading += random.Normal(0, 0.06);
        points.push_back(points.back() + kPiece * cv::Point2d(std::cos(angle), std::sin(angle)));
        if (starts.size() < 4 && random.Uniform() < 0.01) starts.push_back(points.back());
      }
      DrawPath(points, 128 * (1 - strength * random.Uniform(0.5, 1.0)));
      heading += random.Uniform() < 0.5 ? 0.9 : -0.9;
      left *= 0.5;
    }
  }
}

void Wear::ApplyTo(cv::Mat& bgr) const {
  for (int y = 0; y < bgr.rows; ++y) {
    const uint8_t* level = layer_.ptr<uint8_t>(y);
    uint8_t* out = bgr.ptr<uint8_t>(y);
    for (int x = 0; x < bgr.cols; ++x, out += 3) {
      if (level[x] == 128) continue;
      for (int c = 0; c < 3; ++c) out[c] = uint8_t(std::min(255, out[c] * level[x] / 128));
    }
  }
}

}  // namespace gaitcam
