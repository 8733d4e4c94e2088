#include "algorithms/features/sift_descriptor.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/core/hal/intrin.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kGrid = 16;  ///< Sample points per side of either window.
constexpr int kSamples = kGrid * kGrid;
constexpr int kOrientationBins = 36;  ///< Bins of the orientation histogram.
constexpr int kCells = 4, kBins = 8;  ///< Descriptor: cells per side, directions per cell.

using Four = cv::v_float32x4;  ///< Neighbouring samples.
constexpr int kFour = Four::nlanes;

/// Gradients at the sample points of a window.
struct Samples {
  alignas(16) float gx[kSamples], gy[kSamples], magnitude[kSamples], angle[kSamples];

  /// Bilinear, for four samples from the i-th on; outside the image there is no gradient.
  void Take(int i, const cv::Mat& gradients, const Four& x, const Four& y) {
    const cv::v_int32x4 x0 = cv::v_trunc(x), y0 = cv::v_trunc(y);
    const Four zero = cv::v_setzero_f32(), one = cv::v_setall_f32(1);
    const auto inside = cv::v_reinterpret_as_f32((x0 < cv::v_setall_s32(gradients.cols - 1)) &
                                                 (y0 < cv::v_setall_s32(gradients.rows - 1))) &
                        (x >= zero) & (y >= zero);
    alignas(16) int columns[kFour], rows[kFour];
    const cv::v_int32x4 seen = cv::v_reinterpret_as_s32(inside);  // what is not, is taken from the corner
    cv::v_store_aligned(columns, x0 & seen);
    cv::v_store_aligned(rows, y0 & seen);
    const float* const first = gradients.ptr<float>();
    const size_t stride = gradients.step1();
    const auto at = [&](int k) { return first + stride * size_t(rows[k]) + 2 * columns[k]; };
    const float *const p0 = at(0), *const p1 = at(1), *const p2 = at(2), *const p3 = at(3);
    Four x00, y00, x10, y10, x01, y01, x11, y11;  // (gx, gy) at x0 and at x0 + 1, in row y0 and below
    cv::v_transpose4x4(cv::v_load(p0), cv::v_load(p1), cv::v_load(p2), cv::v_load(p3), x00, y00, x10, y10);
    cv::v_transpose4x4(cv::v_load(p0 + stride), cv::v_load(p1 + stride), cv::v_load(p2 + stride),
                       cv::v_load(p3 + stride), x01, y01, x11, y11);
    const Four a = x - cv::v_cvt_f32(x0), b = y - cv::v_cvt_f32(y0);
    const Four w00 = (one - a) * (one - b), w10 = a * (one - b), w01 = (one - a) * b, w11 = a * b;
    cv::v_store_aligned(gx + i, (w00 * x00 + w10 * x10 + w01 * x01 + w11 * x11) & inside);
    cv::v_store_aligned(gy + i, (w00 * y00 + w10 * y10 + w01 * y01 + w11 * y11) & inside);
  }
  /// Equation 5.10; angles in radians, [0, 2 pi).
  void ToPolar() {
    cv::hal::magnitude32f(gx, gy, magnitude, kSamples);
    cv::hal::fastAtan32f(gy, gx, angle, kSamples, false);
  }
};

/// What depends on a sample's place in the window alone.
struct WindowWeights {
  alignas(16) float offset[kGrid];  ///< Of the samples from the centre along one axis, in units of the scale.
  alignas(16) float gaussian[kSamples];

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
  int cell[kGrid];                 ///< The first of the two; -1 and kCells - 1 have one cell only.
  alignas(16) float share[kGrid];  ///< Of the second.

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
    const Four scale = cv::v_setall_f32(p.scale), x = cv::v_setall_f32(p.x);
    for (int j = 0; j < kGrid; ++j) {
      const Four y = cv::v_setall_f32(p.y + p.scale * orientation_.offset[j]);
      for (int i = 0; i < kGrid; i += kFour)
        samples_.Take(j * kGrid + i, gradients, x + scale * cv::v_load_aligned(orientation_.offset + i), y);
    }
    samples_.ToPolar();
    std::array<float, kOrientationBins> histogram{};
    for (int k = 0; k < kSamples; k += kFour) {
      // Shared between the two nearest bins, which the thesis does not say: orientations do not snap to 10 degrees.
      const Four place =
          cv::v_load_aligned(samples_.angle + k) * cv::v_setall_f32(float(kOrientationBins / (2 * CV_PI)));
      const cv::v_int32x4 bin = cv::v_trunc(place);
      const Four share = place - cv::v_cvt_f32(bin);
      const Four weight = cv::v_load_aligned(samples_.magnitude + k) * cv::v_load_aligned(orientation_.gaussian + k);
      alignas(16) int bins[kFour];
      alignas(16) float first[kFour], second[kFour];
      cv::v_store_aligned(bins, bin);
      cv::v_store_aligned(first, weight * (cv::v_setall_f32(1) - share));
      cv::v_store_aligned(second, weight * share);
      for (int i = 0; i < kFour; ++i) {
        const int at = bins[i] < kOrientationBins ? bins[i] : bins[i] - kOrientationBins;
        histogram[size_t(at)] += first[i];
        histogram[size_t(at + 1 < kOrientationBins ? at + 1 : 0)] += second[i];
      }
    }
    return Peaks(Smoothed(Smoothed(histogram)));
  }

  /// Writes kSiftLength values of unit length.
  void Describe(const cv::Mat& gradients, const ScalePoint& p, float orientation, float* out) {
    const float c = std::cos(orientation) * p.scale, s = std::sin(orientation) * p.scale;
    for (int j = 0; j < kGrid; ++j) {
      const float v = descriptor_.offset[j];
      for (int i = 0; i < kGrid; i += kFour) {
        const Four u = cv::v_load_aligned(descriptor_.offset + i);
        const Four x = cv::v_setall_f32(p.x) + cv::v_setall_f32(c) * u - cv::v_setall_f32(s * v);
        const Four y = cv::v_setall_f32(p.y) + cv::v_setall_f32(s) * u + cv::v_setall_f32(c * v);
        samples_.Take(j * kGrid + i, gradients, x, y);
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
    const Four one = cv::v_setall_f32(1);
    for (int k = 0; k < kSamples; k += kFour) {
      const Four direction = (cv::v_load_aligned(samples_.angle + k) - cv::v_setall_f32(orientation)) *
                             cv::v_setall_f32(float(kBins / (2 * CV_PI)));
      const cv::v_int32x4 turn = cv::v_floor(direction);
      const Four share = direction - cv::v_cvt_f32(turn), rest = one - share;
      const Four m = cv::v_load_aligned(samples_.magnitude + k) * cv::v_load_aligned(descriptor_.gaussian + k);
      const Four fx = cv::v_load_aligned(shares_.share + k % kGrid), fy = cv::v_setall_f32(shares_.share[k / kGrid]);
      const Four left = m * (one - fx), right = m * fx;
      alignas(16) int bins[kFour];
      cv::v_store_aligned(bins, turn & cv::v_setall_s32(kBins - 1));
      alignas(16) float of_first[kFour][4], of_second[kFour][4];  // of each sample to the four cells
      ToCells(left * (one - fy) * rest, right * (one - fy) * rest, left * fy * rest, right * fy * rest, of_first);
      ToCells(left * (one - fy) * share, right * (one - fy) * share, left * fy * share, right * fy * share, of_second);
      for (int i = 0; i < kFour; ++i) Add(k + i, bins[i], of_first[i], of_second[i]);
    }
  }

  /// Of each cell four samples, to of each sample four cells.
  static void ToCells(const Four& a, const Four& b, const Four& c, const Four& d, float (&out)[kFour][4]) {
    Four s0, s1, s2, s3;
    cv::v_transpose4x4(a, b, c, d, s0, s1, s2, s3);
    cv::v_store_aligned(out[0], s0);
    cv::v_store_aligned(out[1], s1);
    cv::v_store_aligned(out[2], s2);
    cv::v_store_aligned(out[3], s3);
  }

  /// A sample to the cells around it.
  void Add(int k, int bin, const float* first, const float* second) {
    float* const upper = cells_[shares_.cell[k / kGrid] + 1][shares_.cell[k % kGrid] + 1];
    float* const lower = upper + (kCells + 2) * kBins;
    const int next = (bin + 1) & (kBins - 1);
    upper[bin] += first[0];
    upper[next] += second[0];
    upper[kBins + bin] += first[1];
    upper[kBins + next] += second[1];
    lower[bin] += first[2];
    lower[next] += second[2];
    lower[kBins + bin] += first[3];
    lower[kBins + next] += second[3];
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
    int x = 1;
    for (; x + kFour <= light.cols - 1; x += kFour) {
      cv::v_store_interleave(out + 2 * x, cv::v_load(row + x + 1) - cv::v_load(row + x - 1),
                             cv::v_load(down + x) - cv::v_load(up + x));
    }
    for (; x < light.cols - 1; ++x) {
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

namespace {

/// Of the levels of a scale space, each computed when it is first asked for.
class LevelGradients {
 public:
  explicit LevelGradients(const ScaleSpace& space) : space_(space) {}

  const cv::Mat& operator()(const ScalePoint& p) {
    gradients_.resize(space_.size());
    std::vector<cv::Mat>& octave = gradients_[size_t(p.octave)];
    octave.resize(space_[size_t(p.octave)].levels.size());
    cv::Mat& level = octave[size_t(p.level)];
    if (level.empty()) level = Gradients(space_[size_t(p.octave)].levels[size_t(p.level)].light);
    return level;
  }

 private:
  const ScaleSpace& space_;
  std::vector<std::vector<cv::Mat>> gradients_;  ///< By octave and level.
};

/// As they are given, or if not all features are wanted, those of largest response first.
std::vector<int> OrderToDescribe(const std::vector<ScalePoint>& points, int most) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  if (most == kAllFeatures) return order;
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return points[size_t(a)].response > points[size_t(b)].response; });
  return order;
}

}  // namespace

Features DescribeSift(const ScaleSpace& space, const std::vector<ScalePoint>& points, const SiftOptions& options,
                      int most) {
  CheckFields(options);
  Describer describer(options);
  LevelGradients gradients_of(space);
  Features features;
  std::vector<float> rows;
  const int length = SiftLength(options);
  for (const int i : OrderToDescribe(points, most)) {
    const ScalePoint& p = points[size_t(i)];
    if (features.size() >= most && p.response < features.keypoints.back().response) break;
    const ScaleOctave& octave = space[size_t(p.octave)];
    const cv::Mat& gradients = gradients_of(p);
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
