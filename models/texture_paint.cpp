#include "models/texture_paint.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
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

Wear::Wear(cv::Size size) : layer_(size, CV_8UC1, cv::Scalar(128)) {}

double Wear::Level(double strength, RandomStream& random) const {
  const double change = strength * random.Uniform(0.3, 1.0);
  return 128 * (random.Uniform() < 0.5 ? 1 + change : 1 - change);
}

void Wear::AddSpots(int count, double min_radius_px, double max_radius_px, double strength, RandomStream& random) {
  for (int i = 0; i < count; ++i) {
    const cv::Point2d at(random.Uniform(0, layer_.cols), random.Uniform(0, layer_.rows));
    const double u = random.Uniform();  // many small, few large
    const double radius = min_radius_px * std::pow(max_radius_px / min_radius_px, u * u);
    const double level = Level(strength, random);
    ForWrappedCopies(layer_.size(), at, radius + 1, [&](cv::Point2d shift) {
      cv::circle(layer_, Fixed(at + shift), int(radius * kOne), cv::Scalar(level), cv::FILLED, cv::LINE_AA, kShift);
    });
  }
}

void Wear::AddScratches(int count, double min_length_px, double max_length_px, double strength, RandomStream& random) {
  for (int i = 0; i < count; ++i) {
    const cv::Point2d at(random.Uniform(0, layer_.cols), random.Uniform(0, layer_.rows));
    const double length = random.Uniform(min_length_px, max_length_px), bend = random.Normal(0, 0.6);
    const double level = Level(strength, random);
    double angle = random.Uniform(0, 2 * M_PI);
    std::vector<cv::Point2d> points{at};
    constexpr int kPieces = 6;
    for (int k = 0; k < kPieces; ++k) {
      points.push_back(points.back() + length / kPieces * cv::Point2d(std::cos(angle), std::sin(angle)));
      angle += bend / kPieces + random.Normal(0, 0.1);
    }
    ForWrappedCopies(layer_.size(), at, length + 2, [&](cv::Point2d shift) {
      for (int k = 0; k < kPieces; ++k) {
        cv::line(layer_, Fixed(points[k] + shift), Fixed(points[k + 1] + shift), cv::Scalar(level), 1, cv::LINE_AA,
                 kShift);
      }
    });
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
