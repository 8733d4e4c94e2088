#include "algorithms/features/line_spectra.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kMinFloor = 0.003;  ///< A zero is never seen deeper than this.
/// A floor is measured too high, as a zero's neighbourhood counts for it, and too high a floor shortens the blur (by
/// 0.5 px at 20 px and noise of 5 grey levels), while too low a one costs next to nothing.
constexpr double kNoiseFloorShare = 0.1;
constexpr double kBlurSkewness = 0.5;  ///< From here on (below minus this) a ripple is that of zeros.

double SincSquared(double x) {
  if (std::abs(x) < 1e-6) return 1;
  const double s = std::sin(M_PI * x) / (M_PI * x);
  return s * s;
}

/// Power of a Hann window's transform at x / length, its main lobe alone.
double HannKernel(double x) {
  if (std::abs(x) >= 2) return 0;
  if (std::abs(std::abs(x) - 1) < 1e-6) return 0.25;
  return SincSquared(x) / ((1 - x * x) * (1 - x * x));
}

/// The window's kernel, widened by a bin of `fine` steps; sums to 1.
std::vector<double> SmearingKernel(int window_px, double step, int fine) {
  const int half = int(std::ceil(2 / (window_px * step))) + fine / 2;
  std::vector<double> kernel;
  double total = 0;
  for (int i = -half; i <= half; ++i) {
    double sum = 0;
    for (int j = 0; j < fine; ++j) sum += HannKernel((i + j - 0.5 * (fine - 1)) * step * window_px);
    kernel.push_back(sum);
    total += sum;
  }
  for (double& k : kernel) k /= total;
  return kernel;
}

/// Takes from each value of a row the mean over the values within `reach` of it; they go on mirrored below the first
/// one. What depends on the reach alone is computed once for many rows.
class RunningMean {
 public:
  RunningMean(int n, double reach) : sums_(size_t(n) + 1, 0.0) {
    const auto place = [n](double x) {
      const double y = std::min(double(n) - 1e-9, std::abs(x));
      return Place{size_t(y), y - double(size_t(y)), x < 0};
    };
    for (int b = 0; b < n; ++b) {
      const double low = b + 0.5 - reach, high = std::min(double(n), b + 0.5 + reach);
      windows_.push_back({place(low), place(high), high - low});
    }
  }

  template <class Row>
  void SubtractFrom(Row&& row) {
    for (size_t b = 0; b < windows_.size(); ++b) sums_[b + 1] = sums_[b] + double(row[long(b)]);
    for (size_t b = 0; b < windows_.size(); ++b) {
      const Window& window = windows_[b];
      row[long(b)] -= float((Integral(window.high) - Integral(window.low)) / window.width);
    }
  }

 private:
  struct Place {
    size_t whole = 0;
    double part = 0;
    bool mirrored = false;
  };
  struct Window {
    Place low, high;
    double width = 0;
  };
  double Integral(const Place& at) const {
    const double value = sums_[at.whole] + at.part * (sums_[at.whole + 1] - sums_[at.whole]);
    return at.mirrored ? -value : value;
  }

  std::vector<Window> windows_;  ///< Of each value.
  std::vector<double> sums_;     ///< Of the values before each.
};

}  // namespace

LineSpectra::LineSpectra(int window_px, double min_extent_px, double max_extent_px, double high_frequency)
    : min_extent_px_(min_extent_px),
      high_frequency_(high_frequency),
      extents_(int((max_extent_px - min_extent_px) / kExtentStep) + 1),
      power_(kBins, extents_) {
  GAITCAM_ASSERT(min_extent_px > 0 && max_extent_px > min_extent_px && high_frequency > 0);
  constexpr int kFine = 4;  // steps in a bin
  const double step = high_frequency / (kBins * kFine);
  const std::vector<double> kernel = SmearingKernel(window_px, step, kFine);
  const int reach = int(kernel.size()) / 2;
  std::vector<double> fine(size_t(kBins * kFine + reach + 1));
  for (int e = 0; e < extents_; ++e) {
    const double extent = min_extent_px + e * kExtentStep;
    for (size_t i = 0; i < fine.size(); ++i) fine[i] = SincSquared(extent * double(i) * step);
    for (int b = 0; b < kBins; ++b) {
      double sum = 0;
      for (int k = -reach; k <= reach; ++k) {
        sum += kernel[size_t(k + reach)] * fine[size_t(std::abs(b * kFine + kFine / 2 + k))];
      }
      power_(b, e) = float(sum);
    }
  }
}

/// Calls add(n, bin, value) for each sample, in their order, and each of the directions n.
template <size_t N, class Add>
void LineSpectra::ForEachBin(const LogSpectrum& log, const std::array<double, N>& directions_rad, Add add) const {
  std::array<float, N> c, s;
  for (size_t n = 0; n < N; ++n) {
    c[n] = float(std::cos(directions_rad[n]) * kBins / high_frequency_);
    s[n] = float(std::sin(directions_rad[n]) * kBins / high_frequency_);
  }
  constexpr size_t kAtOnce = cv::v_float32x4::nlanes;
  size_t i = 0;
  for (; i + kAtOnce <= log.samples.size(); i += kAtOnce) {
    static_assert(sizeof(SpectrumSample) == 4 * sizeof(float));
    cv::v_float32x4 fx, fy, value, ring;
    cv::v_load_deinterleave(&log.samples[i].fx, fx, fy, value, ring);
    alignas(16) int bins[N][kAtOnce];
    for (size_t n = 0; n < N; ++n) {
      const auto along = cv::v_trunc(cv::v_abs(fx * cv::v_setall_f32(c[n]) + fy * cv::v_setall_f32(s[n])));
      cv::v_store_aligned(bins[n], cv::v_reinterpret_as_s32(ring) * cv::v_setall_s32(kBins) +
                                       cv::v_min(cv::v_setall_s32(kBins - 1), along));
    }
    for (size_t k = 0; k < kAtOnce; ++k) {
      for (size_t n = 0; n < N; ++n) add(n, bins[n][k], log.samples[i + k].value);
    }
  }
  for (; i < log.samples.size(); ++i) {
    const SpectrumSample& sample = log.samples[i];
    for (size_t n = 0; n < N; ++n) {
      const int along = int(std::abs(sample.fx * c[n] + sample.fy * s[n]));
      add(n, sample.ring * kBins + std::min(kBins - 1, along), sample.value);
    }
  }
}

template <size_t N>
std::array<Eigen::VectorXf, N> LineSpectra::MakeProfiles(const LogSpectrum& log,
                                                         const std::array<double, N>& directions_rad) const {
  std::array<Eigen::VectorXf, N> sums;
  std::array<float*, N> values;
  for (size_t n = 0; n < N; ++n) {
    sums[n] = Eigen::VectorXf::Zero(kRings * kBins);
    values[n] = sums[n].data();
  }
  ForEachBin(log, directions_rad, [&](size_t n, int bin, float value) { values[n][bin] += value; });
  return sums;
}

Eigen::VectorXf LineSpectra::CountSamples(const LogSpectrum& log, double direction_rad) const {
  Eigen::VectorXf counts = Eigen::VectorXf::Zero(kRings * kBins);
  ForEachBin<1>(log, {direction_rad}, [&](size_t, int bin, float) { counts[bin] += 1.0f; });
  return counts;
}

Eigen::VectorXf LineSpectra::CountSamples(const LogSpectrum& log) const {
  constexpr double kAnyDirection = 0.6;
  return CountSamples(log, kAnyDirection);
}

LineSpectra::Templates LineSpectra::MakeTemplates(const Eigen::VectorXf& counts, const std::vector<float>& floors,
                                                  double low_px, double high_px) const {
  GAITCAM_ASSERT(floors.size() == kRings);
  Templates t;
  t.first = std::clamp(int((low_px - min_extent_px_) / kExtentStep), 0, extents_ - 1);
  const int count = std::clamp(int((high_px - min_extent_px_) / kExtentStep) + 1, t.first + 1, extents_) - t.first;
  t.values.resize(kRings * kBins, count);
  t.norms.resize(count);
  for (int e = 0; e < count; ++e) {
    const double half_period = 0.5 / (min_extent_px_ + (t.first + e) * kExtentStep) / high_frequency_ * kBins;
    RunningMean mean(kBins, half_period);
    float squares = 0;
    for (int r = 0; r < kRings; ++r) {
      const auto weight = counts.segment<kBins>(r * kBins);
      auto ripple = t.values.col(e).segment<kBins>(r * kBins);
      const float floor = std::max(float(kMinFloor), floors[size_t(r)]);
      for (int b = 0; b < kBins; ++b) ripple[b] = std::log(power_(b, t.first + e) + floor);
      mean.SubtractFrom(ripple);
      const float total = weight.sum();
      if (total > 0) ripple.array() -= weight.dot(ripple) / total;
      squares += (weight.array() * ripple.array().square()).sum();
    }
    t.norms[e] = std::sqrt(squares);
  }
  return t;
}

std::array<Eigen::VectorXf, 2> LineSpectra::Correlate(const LogSpectrum& log, const Templates& templates,
                                                      const std::array<double, 2>& directions_rad) const {
  const float length = log.deviation * std::sqrt(float(log.samples.size()));
  std::array<Eigen::VectorXf, 2> correlations;
  correlations.fill(Eigen::VectorXf::Zero(templates.norms.size()));
  if (!(length > 0)) return correlations;
  const auto profiles = MakeProfiles(log, directions_rad);
  for (size_t n = 0; n < 2; ++n) {
    const Eigen::VectorXf dots = templates.values.transpose() * profiles[n];
    correlations[n] = dots.array() / (templates.norms.array() * length);
  }
  return correlations;
}

Eigen::VectorXf LineSpectra::Correlate(const LogSpectrum& log, const Templates& templates, double direction_rad) const {
  const float length = log.deviation * std::sqrt(float(log.samples.size()));
  if (!(length > 0)) return Eigen::VectorXf::Zero(templates.norms.size());
  const Eigen::VectorXf dots = templates.values.transpose() * MakeProfiles<1>(log, {direction_rad})[0];
  return dots.array() / (templates.norms.array() * length);
}

LineFit LineSpectra::Best(const Templates& templates, const Eigen::VectorXf& correlations, int begin, int end) const {
  GAITCAM_ASSERT(begin >= 0 && begin < end && end <= correlations.size());
  int best = begin;
  for (int e = begin; e < end; ++e) {
    if (correlations[e] > correlations[best]) best = e;
  }
  LineFit fit;
  fit.correlation = double(correlations[best]);
  double offset = 0;
  if (best > 0 && best + 1 < correlations.size()) {
    const double before = double(correlations[best - 1]), after = double(correlations[best + 1]);
    const double curvature = before - 2 * fit.correlation + after;
    if (curvature < 0) offset = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
    fit.correlation -= 0.25 * (before - after) * offset;
  }
  fit.extent_px = min_extent_px_ + (templates.first + best + offset) * kExtentStep;
  return fit;
}

int LineSpectra::Index(const Templates& templates, double extent_px) const {
  const int row = int(std::ceil((extent_px - min_extent_px_) / kExtentStep)) - templates.first;
  return std::clamp(row, 0, int(templates.norms.size()));
}

std::vector<float> LineSpectra::MeasureFloors(const LogSpectrum& log, const LineFit& fit,
                                              const std::vector<float>& otherwise) const {
  constexpr float kLit = 0.3f, kDark = 0.08f;  // of a period from its middle, and from zeros
  constexpr int kMinSamples = 8;
  struct Mean {
    double sum = 0;
    int count = 0;
  };
  std::vector<Mean> lit(kRings), dark(kRings);
  const float c = float(std::cos(fit.direction_rad) * fit.extent_px);
  const float s = float(std::sin(fit.direction_rad) * fit.extent_px);
  for (const SpectrumSample& sample : log.samples) {
    const float u = std::abs(sample.fx * c + sample.fy * s), zero = std::round(u);
    const bool is_dark = zero >= 1 && zero <= 3 && std::abs(u - zero) < kDark;
    if (u >= kLit && !is_dark) continue;
    Mean& mean = (is_dark ? dark : lit)[size_t(sample.ring)];
    mean.sum += double(sample.value);
    ++mean.count;
  }
  std::vector<float> floors = otherwise;
  for (size_t r = 0; r < size_t(kRings); ++r) {
    if (lit[r].count < kMinSamples || dark[r].count < kMinSamples) continue;
    floors[r] = float(kNoiseFloorShare * std::exp(dark[r].sum / dark[r].count - lit[r].sum / lit[r].count));
  }
  return floors;
}

double LineSpectra::Agreement(const LogSpectrum& log, const Templates& templates, const LineFit& fit) const {
  Eigen::VectorXf sums = MakeProfiles<1>(log, {fit.direction_rad})[0];
  Eigen::VectorXf counts = CountSamples(log, fit.direction_rad);
  const double row = (fit.extent_px - min_extent_px_) / kExtentStep - templates.first;
  const int nearest = std::clamp(int(std::lround(row)), 0, int(templates.norms.size()) - 1);
  // Any image with a main direction has a lobe in the middle: what tells blur is the first zero and what lies beyond.
  constexpr double kFromPeriod = 0.6;
  const int first = std::min(kBins - 1, int(kFromPeriod / fit.extent_px / high_frequency_ * kBins));
  RunningMean mean(kBins, 0.5 / fit.extent_px / high_frequency_ * kBins);
  double dot = 0, seen = 0, expected = 0, cubes = 0, total = 0;
  for (int r = 0; r < kRings; ++r) {
    auto values = sums.segment<kBins>(r * kBins);
    const auto weight = counts.segment<kBins>(r * kBins);
    for (int b = 0; b < kBins; ++b) values[b] = weight[b] > 0 ? values[b] / weight[b] : b > 0 ? values[b - 1] : 0;
    mean.SubtractFrom(values);
    const auto ripple = templates.values.col(nearest).segment<kBins>(r * kBins);
    counts.segment(r * kBins, first).setZero();
    dot += double((weight.array() * values.array() * ripple.array()).sum());
    seen += double((weight.array() * values.array().square()).sum());
    expected += double((weight.array() * ripple.array().square()).sum());
    cubes += double((weight.array() * values.array().cube()).sum());
    total += double(weight.sum());
  }
  if (!(seen > 0) || !(expected > 0)) return 0;
  // Zeros are narrow and deep: skewness -0.8 and less. A periodic image has narrow peaks instead; a chessboard -0.1.
  const double skewness = cubes / total / std::pow(seen / total, 1.5);
  return dot / std::sqrt(seen * expected) * std::clamp(-skewness / kBlurSkewness, 0.0, 1.0);
}

}  // namespace gaitcam
