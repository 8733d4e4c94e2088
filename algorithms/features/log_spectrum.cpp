#include "algorithms/features/log_spectrum.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kFineRings = 4;  ///< In each ring, over which means are taken.
constexpr double kLowShare = 0.1, kHighShare = 0.95;

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

LogSpectrum MakeLogSpectrum(const PowerSpectrum& spectrum, double low, double high, int rings) {
  const int n = spectrum.window_px(), last = std::min(n / 2, int(high * n));
  const float scale = 1.0f / float(n), min_power = 1e-12f;
  const int fine_rings = rings * kFineRings;
  const float rings_per_frequency = float(fine_rings / (high - low));
  LogSpectrum log;
  std::vector<std::vector<float>> values(static_cast<size_t>(fine_rings));
  for (int row = -last; row <= last; ++row) {
    const float* power = spectrum.power().ptr<float>((row + n) % n);
    for (int x = row > 0 ? 0 : 1; x <= last; ++x) {
      const float fx = float(x) * scale, fy = float(row) * scale, radius = std::sqrt(fx * fx + fy * fy);
      if (radius < float(low) || radius > float(high)) continue;
      const int ring = std::min(fine_rings - 1, int((radius - float(low)) * rings_per_frequency));
      log.samples.push_back({fx, fy, std::log(power[x] + min_power), ring});
      values[size_t(ring)].push_back(log.samples.back().value);
    }
  }
  std::vector<float> means;
  log.floors.assign(size_t(rings), 0.0f);
  for (int r = 0; r < fine_rings; ++r) {
    std::vector<float>& ring = values[size_t(r)];
    double sum = 0;
    for (const float v : ring) sum += double(v);
    means.push_back(ring.empty() ? 0.0f : float(sum / double(ring.size())));
    if (ring.empty()) continue;
    const auto low_rank = ring.begin() + long(kLowShare * double(ring.size()));
    const auto high_rank = ring.begin() + long(kHighShare * double(ring.size()));
    std::nth_element(ring.begin(), low_rank, ring.end());
    const float least = *low_rank;
    std::nth_element(ring.begin(), high_rank, ring.end());
    log.floors[size_t(r / kFineRings)] += std::exp(least - *high_rank) / float(kFineRings);
  }
  double squares = 0;
  for (SpectrumSample& s : log.samples) {
    s.value -= means[size_t(s.ring)];
    s.ring /= kFineRings;
    squares += double(s.value) * double(s.value);
  }
  log.deviation = float(std::sqrt(squares / double(std::max<size_t>(1, log.samples.size()))));
  return log;
}

}  // namespace gaitcam
