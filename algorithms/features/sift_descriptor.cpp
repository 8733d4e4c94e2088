#include "algorithms/features/sift_descriptor.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core/hal/hal.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kGrid = 16;  ///< Sample points per side of either window.
constexpr int kSamples = kGrid * kGrid;
constexpr int kOrientationBins = 36;  ///< Bins of the orientation histogram.
constexpr int kCells = 4, kBins = 8;  ///< Descriptor: cells per side, directions per cell.

/// Gradients at the sample points of a window.
struct Samples {
  alignas(16) float gx[kSamples], gy[kSamples], magnitude[kSamples], angle[kSamples];

  /// Bilinear; outside the image there is no gradient.
  void Take(int i, const cv::Mat& gradients, float x, float y) {
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 >= gradients.cols - 1 || y0 >= gradients.rows - 1) {
      gx[i] = gy[i] = 0;
      return;
    }
    const float a = x - float(x0), b = y - float(y0);
    const float* p = gradients.ptr<float>(y0) + 2 * x0;
    const float* q = gradients.ptr<float>(y0 + 1) + 2 * x0;
    const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
    gx[i] = w00 * p[0] + w10 * p[2] + w01 * q[0] + w11 * q[2];
    gy[i] = w00 * p[1] + w10 * p[3] + w01 * q[1] + w11 * q[3];
  }
  /// Equation 5.10; angles in radians, [0, 2 pi).
  void ToPolar() {
    cv::hal::magnitude32f(gx, gy, magnitude, kSamples);
    cv::hal::fastAtan32f(gy, gx, angle, kSamples, false);
  }
};

/// What depends on a sample's place in the window alone.
struct WindowWeights {
  float offset[kGrid];  ///< Of the samples from the centre along one axis, in units of the scale.
  float gaussian[kSamples];

  WindowWeights(double window, double sigma) {
    for (int i = 0; i < kGrid; ++i) offset[i] = float((i - (kGrid - 1) / 2.0) * window / kGrid);
    for (int j = 0; j < kGrid; ++j)
      for (int i = 0; i < kGrid; ++i)
        gaussian[j * kGrid + i] =
            float(std::exp(-(offset[i] * offset[i] + offset[j] * offset[j]) / (2 * sigma * sigma)));
  }
};

/// Share of a sample's column (or row) in the two nearest cells: weight 1 - d, d in units of the cells' spacing.
struct CellShares {
  int cell[kGrid];     ///< The first of the two; -1 and kCells - 1 have one cell only.
  float share[kGrid];  ///< Of the second.

  CellShares() {
    for (int i = 0; i < kGrid; ++i) {
      const double place = (i + 0.5) * kCells / kGrid - 0.5;
      cell[i] = int(std::floor(place));
      share[i] = float(place - cell[i]);
    }
  }
};

class Describer {
 public:
  explicit Describer(const SiftOptions& options)
      : options_(options),
        orientation_(options.orientation_window, options.orientation_sigma),
        descriptor_(options.descriptor_window, options.descriptor_sigma) {}

  /// Radians.
  std::vector<float> Orientations(const cv::Mat& gradients, const ScalePoint& p) {
    for (int j = 0, k = 0; j < kGrid; ++j)
      for (int i = 0; i < kGrid; ++i, ++k)
        samples_.Take(k, gradients, p.x + p.scale * orientation_.offset[i], p.y + p.scale * orientation_.offset[j]);
    samples_.ToPolar();
    std::array<float, kOrientationBins> histogram{};
    for (int k = 0; k < kSamples; ++k) {
      // Shared between the two nearest bins, which the thesis does not say: orientations do not snap to 10 degrees.
      const float place = samples_.angle[k] * float(kOrientationBins / (2 * CV_PI));
      const int bin = int(place);
      const float share = place - float(bin), weight = samples_.magnitude[k] * orientation_.gaussian[k];
      histogram[size_t(bin % kOrientationBins)] += weight * (1 - share);
      histogram[size_t((bin + 1) % kOrientationBins)] += weight * share;
    }
    return Peaks(Smoothed(Smoothed(histogram)));
  }

  /// Writes kSiftLength values of unit length.
  void Describe(const cv::Mat& gradients, const ScalePoint& p, float orientation, float* out) {
    const float c = std::cos(orientation) * p.scale, s = std::sin(orientation) * p.scale;
    for (int j = 0, k = 0; j < kGrid; ++j) {
      const float v = descriptor_.offset[j];
      for (int i = 0; i < kGrid; ++i, ++k) {
        const float u = descriptor_.offset[i];
        samples_.Take(k, gradients, p.x + c * u - s * v, p.y + s * u + c * v);
      }
    }
    samples_.ToPolar();
    Accumulate(orientation);
    Normalise(out);
  }

 private:
  using Histogram = std::array<float, kOrientationBins>;

  static Histogram Smoothed(const Histogram& h) {
    Histogram smooth;
    for (size_t i = 0; i < kOrientationBins; ++i)
      smooth[i] = 0.25f * h[(i + kOrientationBins - 1) % kOrientationBins] + 0.5f * h[i] +
                  0.25f * h[(i + 1) % kOrientationBins];
    return smooth;
  }

  /// Interpolated with the neighbouring bins.
  std::vector<float> Peaks(const Histogram& h) const {
    std::vector<float> peaks;
    const float limit = float(options_.orientation_peak) * *std::max_element(h.begin(), h.end());
    for (size_t i = 0; i < kOrientationBins && limit > 0; ++i) {
      const float before = h[(i + kOrientationBins - 1) % kOrientationBins], after = h[(i + 1) % kOrientationBins];
      if (h[i] < limit || h[i] <= before || h[i] < after) continue;
      const float offset = 0.5f * (before - after) / (before - 2 * h[i] + after);
      peaks.push_back((float(i) + offset) * float(2 * CV_PI / kOrientationBins));
    }
    return peaks;
  }

  /// Each gradient, turned by the orientation, into the two nearest directions of up to four cells. The cells have a
  /// frame around them that catches what falls outside.
  void Accumulate(float orientation) {
    std::memset(cells_, 0, sizeof(cells_));
    for (int k = 0; k < kSamples; ++k) {
      float direction = (samples_.angle[k] - orientation) * float(kBins / (2 * CV_PI));
      const float turn = std::floor(direction);
      const float share = direction - turn;
      const int first = int(turn) & (kBins - 1), second = (first + 1) & (kBins - 1);
      const int row = k / kGrid, column = k % kGrid;
      const float m = samples_.magnitude[k] * descriptor_.gaussian[k];
      const float fx = shares_.share[column], fy = shares_.share[row];
      float* cell = cells_[shares_.cell[row] + 1][shares_.cell[column] + 1];
      const auto add = [&](float* bins, float weight) {
        bins[first] += weight * (1 - share);
        bins[second] += weight * share;
      };
      add(cell, m * (1 - fx) * (1 - fy));
      add(cell + kBins, m * fx * (1 - fy));
      add(cell + (kCells + 2) * kBins, m * (1 - fx) * fy);
      add(cell + (kCells + 3) * kBins, m * fx * fy);
    }
  }

  void Normalise(float* out) const {
    for (int j = 0, k = 0; j < kCells; ++j)
      for (int i = 0; i < kCells; ++i)
        for (int b = 0; b < kBins; ++b) out[k++] = cells_[j + 1][i + 1][b];
    Eigen::Map<Eigen::Array<float, kSiftLength, 1>> d(out);
    constexpr float kTiny = 1e-12f;  // a window without any gradient stays zero
    d /= std::max(d.matrix().norm(), kTiny);
    d = d.min(float(options_.clip));
    if (options_.root) {
      d = (d / std::max(d.sum(), kTiny)).sqrt();
    } else {
      d /= std::max(d.matrix().norm(), kTiny);
    }
  }

  const SiftOptions options_;
  const WindowWeights orientation_, descriptor_;
  const CellShares shares_;
  Samples samples_;
  float cells_[kCells + 2][kCells + 2][kBins];
};

}  // namespace

cv::Mat Gradients(const cv::Mat& light) {
  GAITCAM_ASSERT(light.type() == CV_32FC1);
  cv::Mat gradients = cv::Mat::zeros(light.size(), CV_32FC2);
  for (int y = 1; y < light.rows - 1; ++y) {
    const float *row = light.ptr<float>(y), *up = light.ptr<float>(y - 1), *down = light.ptr<float>(y + 1);
    float* out = gradients.ptr<float>(y);
    for (int x = 1; x < light.cols - 1; ++x) {
      out[2 * x] = row[x + 1] - row[x - 1];
      out[2 * x + 1] = down[x] - up[x];
    }
  }
  return gradients;
}

int SiftLength(const SiftOptions& options) {
  constexpr int kKinds = 3;
  return kSiftLength + (options.kind_weight > 0 ? kKinds : 0);
}

Features DescribeSift(const ScaleSpace& space, const std::vector<ScalePoint>& points, const SiftOptions& options) {
  CheckFields(options);
  Describer describer(options);
  Features features;
  std::vector<float> rows;
  const int length = SiftLength(options);
  cv::Mat gradients;
  int of_octave = -1, of_level = -1;
  for (const ScalePoint& p : points) {
    const ScaleOctave& octave = space[size_t(p.octave)];
    if (p.octave != of_octave || p.level != of_level) gradients = Gradients(octave.levels[size_t(p.level)].light);
    of_octave = p.octave;
    of_level = p.level;
    for (const float orientation : describer.Orientations(gradients, p)) {
      const size_t row = rows.size();
      rows.resize(row + size_t(length), 0);
      describer.Describe(gradients, p, orientation, rows.data() + row);
      if (length > kSiftLength) rows[row + kSiftLength + size_t(p.kind)] = float(options.kind_weight);
      const double degrees = std::fmod(orientation * 180 / CV_PI + 360, 360);
      features.keypoints.emplace_back(
          cv::Point2f(float(octave.origin_px + octave.pitch_px * p.x), float(octave.origin_px + octave.pitch_px * p.y)),
          float(2 * p.scale * octave.pitch_px), float(degrees), p.response, p.octave);
    }
  }
  features.descriptors = cv::Mat(features.size(), length, CV_32FC1);
  if (!rows.empty()) std::memcpy(features.descriptors.data, rows.data(), rows.size() * sizeof(float));
  return features;
}

}  // namespace gaitcam
