#include "algorithms/features/log_spectrum.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kRings = 24;

std::vector<float> HannWindow(int length) {
  std::vector<float> window(static_cast<size_t>(length));
  for (int i = 0; i < length; ++i) window[size_t(i)] = float(0.5 - 0.5 * std::cos(2 * M_PI * (i + 0.5) / length));
  return window;
}

/// First pixels of windows that cover `length`, each overlapping the next by half or more.
std::vector<int> Starts(int length, int window) {
  const int free = length - window;
  if (free <= 0) return {0};
  const int steps = (2 * free + window - 1) / window;
  std::vector<int> starts;
  for (int i = 0; i <= steps; ++i) starts.push_back(int(int64_t(free) * i / steps));
  return starts;
}

/// Adds scale * |F|^2 from OpenCV's packed layout of a real image's transform (CCS).
void AddPackedPower(const cv::Mat& packed, float scale, cv::Mat& power) {
  const int n = packed.rows;
  for (int y = 0; y < n; ++y) {
    const float* row = packed.ptr<float>(y);
    float* sum = power.ptr<float>(y);
    for (int x = 1; x < n / 2; ++x) {
      sum[x] += scale * (row[2 * x - 1] * row[2 * x - 1] + row[2 * x] * row[2 * x]);
    }
  }
  // Columns 0 and n/2 hold real parts in odd and imaginary parts in even rows below the first.
  for (const int x : {0, n / 2}) {
    const int column = x == 0 ? 0 : n - 1;
    const auto at = [&](int y) { return packed.at<float>(y, column); };
    power.at<float>(0, x) += scale * at(0) * at(0);
    power.at<float>(n / 2, x) += scale * at(n - 1) * at(n - 1);
    for (int y = 1; y < n / 2; ++y) {
      const float p = scale * (at(2 * y - 1) * at(2 * y - 1) + at(2 * y) * at(2 * y));
      power.at<float>(y, x) += p;
      power.at<float>(n - y, x) += p;
    }
  }
}

}  // namespace

PowerSpectrum::PowerSpectrum(int window_px)
    : window_px_(window_px), power_(window_px, window_px / 2 + 1, CV_32FC1, cv::Scalar(0)) {
  GAITCAM_ASSERT(window_px >= 8 && (window_px & (window_px - 1)) == 0);
}

void PowerSpectrum::Add(const cv::Mat& laplacian) {
  GAITCAM_ASSERT(laplacian.type() == CV_32FC1);
  const int n = window_px_, width = std::min(n, laplacian.cols), height = std::min(n, laplacian.rows);
  const std::vector<float> wx = HannWindow(width), wy = HannWindow(height);
  cv::Mat window(n, n, CV_32FC1, cv::Scalar(0)), packed;
  for (const int top : Starts(laplacian.rows, n)) {
    for (const int left : Starts(laplacian.cols, n)) {
      double energy = 0;
      for (int y = 0; y < height; ++y) {
        const float* from = laplacian.ptr<float>(top + y) + left;
        float* to = window.ptr<float>(y);
        float sum = 0;
        for (int x = 0; x < width; ++x) {
          to[x] = from[x] * wx[size_t(x)] * wy[size_t(y)];
          sum += to[x] * to[x];
        }
        energy += double(sum);
      }
      if (energy < 1e-3 * width * height) continue;  // flat
      cv::dft(window, packed, 0, height);
      AddPackedPower(packed, float(1 / std::sqrt(energy)), power_);
      ++windows_;
    }
  }
}

PowerSpectrum PowerSpectrum::Halved() const {
  PowerSpectrum half(window_px_ / 2);
  half.windows_ = windows_;
  const int n = window_px_, m = n / 2;
  // A frequency of the coarse grid takes itself whole and its neighbours on the fine grid by half.
  const auto row_sum = [&](int y, int x) {
    const float* row = power_.ptr<float>((y + n) % n);
    const float before = x > 0 ? row[x - 1] : power_.at<float>((n - y) % n, 1);
    const float after = x < n / 2 ? row[x + 1] : power_.at<float>((n - y) % n, n / 2 - 1);
    return row[x] + 0.5f * (before + after);
  };
  for (int y = 0; y < m; ++y) {
    for (int x = 0; x <= m / 2; ++x) {
      half.power_.at<float>(y, x) =
          row_sum(2 * y, 2 * x) + 0.5f * (row_sum(2 * y - 1, 2 * x) + row_sum(2 * y + 1, 2 * x));
    }
  }
  return half;
}

cv::Mat Laplacian(const cv::Mat& grey) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1 && grey.rows > 2 && grey.cols > 2);
  cv::Mat out(grey.rows - 2, grey.cols - 2, CV_32FC1);
  for (int y = 0; y < out.rows; ++y) {
    const uchar* above = grey.ptr<uchar>(y) + 1;
    const uchar* at = grey.ptr<uchar>(y + 1) + 1;
    const uchar* below = grey.ptr<uchar>(y + 2) + 1;
    float* to = out.ptr<float>(y);
    for (int x = 0; x < out.cols; ++x) to[x] = float(4 * at[x] - at[x - 1] - at[x + 1] - above[x] - below[x]);
  }
  return out;
}

std::vector<SpectrumSample> WhitenSpectrum(const PowerSpectrum& spectrum, double low, double high) {
  const int n = spectrum.window_px(), last = std::min(n / 2, int(high * n));
  const float scale = 1.0f / float(n), floor = 1e-12f;
  std::vector<SpectrumSample> samples;
  std::vector<int> rings;
  std::vector<double> sum(kRings, 0.0);
  std::vector<int> count(kRings, 0);
  for (int row = -last; row <= last; ++row) {
    const float* power = spectrum.power().ptr<float>((row + n) % n);
    for (int x = row > 0 ? 0 : 1; x <= last; ++x) {
      const float fx = float(x) * scale, fy = float(row) * scale, radius = std::sqrt(fx * fx + fy * fy);
      if (radius < float(low) || radius > float(high)) continue;
      const int ring = std::min(kRings - 1, int((radius - float(low)) / float(high - low) * kRings));
      samples.push_back({fx, fy, std::log(power[x] + floor)});
      rings.push_back(ring);
      sum[size_t(ring)] += double(samples.back().value);
      ++count[size_t(ring)];
    }
  }
  double squares = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const size_t ring = size_t(rings[i]);
    samples[i].value -= float(sum[ring] / count[ring]);
    squares += double(samples[i].value) * double(samples[i].value);
  }
  const float deviation = float(std::sqrt(squares / double(std::max<size_t>(1, samples.size()))));
  for (SpectrumSample& s : samples) s.value = deviation > 0 ? std::clamp(s.value / deviation, -3.0f, 3.0f) : 0.0f;
  return samples;
}

}  // namespace gaitcam
