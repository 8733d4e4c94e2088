#include "algorithms/places/wavelet_signature.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string>

namespace gaitcam {
namespace {

constexpr float kNoDetail = 1e-5f;  // of the image's range: what rounding leaves of 0
constexpr int kDownParts = 4;       // pixels are averaged by square / kDownParts down the image

/// Not normalised.
double Gaussian(double x, double sigma) { return std::exp(-0.5 * x * x / (sigma * sigma)); }

/// Sigma of the filter that is left to do on pixels averaged by `factor`, in such pixels: averaging has a variance of
/// (factor^2 - 1) / 12 already.
double RestSigma(double sigma, int factor) {
  return std::sqrt(sigma * sigma - (double(factor) * factor - 1) / 12) / factor;
}

/// Weights of averaged pixels in the Gaussian-filtered mean over `run` of them, the first at 0: index 0 is that of
/// pixel -radius. Sum 1.
std::vector<float> FilteredMean(double sigma, int run, int radius) {
  std::vector<double> weights(size_t(2 * radius + run), 0.0);
  double sum = 0;
  for (int member = 0; member < run; ++member) {
    for (int distance = -radius; distance <= radius; ++distance) {
      const double weight = Gaussian(distance, sigma);
      weights[size_t(member + distance + radius)] += weight;
      sum += weight;
    }
  }
  std::vector<float> normalised;
  for (const double weight : weights) normalised.push_back(float(weight / sum));
  return normalised;
}

int RadiusOf(double sigma) { return int(std::ceil(3.5 * sigma)); }

/// The words of bits [begin, begin + 64 count), which may overlap; one word behind them must be readable.
void Extract(const uint64_t* words, size_t begin, size_t count, uint64_t* out) {
  const uint64_t* from = words + begin / 64;
  const unsigned shift = unsigned(begin % 64);
  for (size_t k = 0; k < count; ++k) out[k] = (from[k] >> shift) | ((from[k + 1] << 1) << (63 - shift));
}

constexpr int kRefineShifts = 6;           // a fit is refined by its neighbours up to here, ...
constexpr double kRefineTolerance = 0.05;  // ... where not more than this part of the bits differs in addition
constexpr size_t kMostWords = 64;          // of a view's signature: 4096 bits

/// A view's signatures as words of equal number, and which bits belong to which band.
struct Probe {
  size_t words = 0, bits = 0;
  std::vector<uint64_t> signatures;  // shift by shift
  std::vector<uint64_t> all, vertical, diagonal;
};

/// Diss of Eq. 4.4 if all bits differed.
double GreatestDissimilarity(const Probe& probe, const WaveletOptions& options) {
  return 2 * double(probe.bits / 3) * (options.weight_h + options.weight_v + options.weight_d);
}

/// Sums of Eq. 4.4 without the weights.
struct Differences {
  int all = 0, vertical = 0, diagonal = 0;
};

template <bool kDiagonals>
[[gnu::always_inline]] inline Differences Compare(const uint64_t* a, const uint64_t* b, const Probe& probe) {
  Differences differences;
  for (size_t k = 0; k < probe.words; ++k) {
    const uint64_t differ = (a[k] ^ b[k]) & probe.all[k];
    differences.all += __builtin_popcountll(differ);
    differences.vertical += __builtin_popcountll(differ & probe.vertical[k]);
    if constexpr (kDiagonals) differences.diagonal += __builtin_popcountll(differ & probe.diagonal[k]);
  }
  return differences;
}

struct Best {
  double dissimilarity = 1e300;
  int place = 0;  ///< Of the view's left edge, in shifts from the panorama's.
};

/// Columns where a view may begin; round the seam.
struct Columns {
  int first = 0, count = 0;
};

/// One panorama and one view, by their bits.
template <bool kDiagonals>
struct Comparison {
  const uint64_t* ring;  ///< The panorama, the columns of which are repeated behind its end.
  int columns, bits_per_column;
  Columns searched;
  const Probe& probe;
  const WaveletOptions& options;

  [[gnu::always_inline]] inline void Window(int column, uint64_t* window) const {
    Extract(ring, size_t(column) * size_t(bits_per_column), probe.words, window);
  }
  /// Eq. 4.4; |d_i - d_r| of two signs that differ is 2.
  [[gnu::always_inline]] inline double Dissimilarity(const uint64_t* window, int shift) const {
    const Differences differ = Compare<kDiagonals>(window, &probe.signatures[size_t(shift) * probe.words], probe);
    double sum = options.weight_h * differ.all + (options.weight_v - options.weight_h) * differ.vertical;
    if constexpr (kDiagonals) sum += (options.weight_d - options.weight_h) * differ.diagonal;
    return 2 * sum;
  }
};

/// Slides the view over the panorama, shift by shift.
template <bool kDiagonals>
[[gnu::always_inline]] inline Best Slide(const Comparison<kDiagonals>& comparison) {
  Best best;
  uint64_t window[kMostWords];
  for (int k = 0; k < comparison.searched.count; ++k) {
    const int column = (comparison.searched.first + k) % comparison.columns;
    comparison.Window(column, window);
    for (int shift = 0; shift < WaveletOptions::kShifts; ++shift) {
      const double dissimilarity = comparison.Dissimilarity(window, shift);
      if (dissimilarity < best.dissimilarity) best = {dissimilarity, WaveletOptions::kShifts * column - shift};
    }
  }
  return best;
}

/// How far from the best place, in shifts, the middle of all places about it lies that are nearly as good: one bit more
/// or less decides between neighbours, many of them about their middle.
template <bool kDiagonals>
double Refine(const Comparison<kDiagonals>& comparison, const Best& best, double tolerance) {
  uint64_t window[kMostWords];
  double sum = 0, moment = 0;
  for (int step = -kRefineShifts; step <= kRefineShifts; ++step) {
    const int place = best.place + step, shifts = WaveletOptions::kShifts;
    const int column =
        (place + 2 * shifts * comparison.columns + shifts - 1) / shifts;  // rounded up, no longer negative
    comparison.Window(column % comparison.columns, window);
    const int shift = shifts * column - place - 2 * shifts * comparison.columns;
    const double weight = best.dissimilarity + tolerance - comparison.Dissimilarity(window, shift);
    if (weight <= 0) continue;
    sum += weight;
    moment += weight * step;
  }
  return moment / sum;
}

struct Fit {
  Best best;
  double refined = 0;  ///< Place, in shifts.
};

template <bool kDiagonals>
[[gnu::always_inline]] inline Fit FitWith(const uint64_t* ring, int columns, int bits, Columns searched,
                                          const Probe& probe, const WaveletOptions& options) {
  const Comparison<kDiagonals> comparison{ring, columns, bits, searched, probe, options};
  const Best best = Slide(comparison);
  return {best, best.place + Refine(comparison, best, kRefineTolerance * GreatestDissimilarity(probe, options))};
}

using FitFunction = Fit (*)(const uint64_t*, int, int, Columns, const Probe&, const WaveletOptions&);

template <bool kDiagonals>
Fit FitPlain(const uint64_t* ring, int columns, int bits, Columns searched, const Probe& probe,
             const WaveletOptions& options) {
  return FitWith<kDiagonals>(ring, columns, bits, searched, probe, options);
}

#if defined(__x86_64__)
/// The same where the processor counts bits by an instruction, as all since 2008 do.
template <bool kDiagonals>
[[gnu::target("popcnt")]] Fit FitPopcnt(const uint64_t* ring, int columns, int bits, Columns searched,
                                        const Probe& probe, const WaveletOptions& options) {
  return FitWith<kDiagonals>(ring, columns, bits, searched, probe, options);
}
#endif

FitFunction FitFor(const WaveletOptions& options) {
  const bool diagonals = options.weight_d != options.weight_h;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("popcnt")) return diagonals ? FitPopcnt<true> : FitPopcnt<false>;
#endif
  return diagonals ? FitPlain<true> : FitPlain<false>;
}

Probe ProbeOf(const WaveletView& view) {
  const WaveletSignature& first = view.shifts.front();
  Probe probe;
  probe.bits = size_t(first.bits_per_column()) * size_t(first.columns());
  probe.words = first.words().size();
  WaveletSignature all(first.columns(), first.rows()), vertical = all, diagonal = all;
  for (int column = 0; column < first.columns(); ++column) {
    for (int row = 0; row < first.rows(); ++row) {
      for (const auto band : {WaveletSignature::kHorizontal, WaveletSignature::kVertical, WaveletSignature::kDiagonal})
        all.Set(band, row, column, true);
      vertical.Set(WaveletSignature::kVertical, row, column, true);
      diagonal.Set(WaveletSignature::kDiagonal, row, column, true);
    }
  }
  probe.all = all.words();
  probe.vertical = vertical.words();
  probe.diagonal = diagonal.words();
  for (const WaveletSignature& shift : view.shifts)
    probe.signatures.insert(probe.signatures.end(), shift.words().begin(), shift.words().end());
  return probe;
}

/// A panorama's bits, then as many of its first ones again as a view that begins in the last column needs.
class Ring {
 public:
  Ring(size_t bits, size_t view_bits)
      : bits_(bits), words_((bits + view_bits) / 64 + 3, 0), view_words_(view_bits / 64 + 1) {}

  const uint64_t* Load(const uint8_t* packed, size_t bytes) {
    std::fill(words_.begin(), words_.end(), 0);
    std::memcpy(words_.data(), packed, bytes);  // little-endian words, as x86 and ARM have them
    const size_t at = bits_ / 64;
    const unsigned shift = unsigned(bits_ % 64);
    for (size_t k = 0; k < view_words_ && at + k + 1 < words_.size(); ++k) {
      const uint64_t first = words_[k];
      words_[at + k] |= first << shift;
      if (shift > 0) words_[at + k + 1] |= first >> (64 - shift);
    }
    return words_.data();
  }

 private:
  size_t bits_;
  std::vector<uint64_t> words_;
  size_t view_words_;
};

WaveletMatch MatchOf(const Fit& fit, const Probe& probe, const WaveletOptions& options) {
  WaveletMatch match;
  match.disagreement = fit.best.dissimilarity / GreatestDissimilarity(probe, options);
  match.similarity = SimilarityOf(match.disagreement, int(probe.bits));
  match.left_px = options.shift_px() * fit.refined;
  return match;
}

}  // namespace

WaveletSignature::WaveletSignature(int columns, int rows)
    : columns_(columns), rows_(rows), words_((size_t(columns) * size_t(3 * rows) + 63) / 64, 0) {}

size_t WaveletSignature::Index(Band band, int row, int column) const {
  return size_t(column) * size_t(bits_per_column()) + size_t(band) * size_t(rows_) + size_t(row);
}

bool WaveletSignature::Bit(Band band, int row, int column) const {
  const size_t index = Index(band, row, column);
  return words_[index / 64] >> (index % 64) & 1;
}

void WaveletSignature::Set(Band band, int row, int column, bool value) {
  const size_t index = Index(band, row, column);
  const uint64_t bit = uint64_t(1) << (index % 64);
  words_[index / 64] = value ? words_[index / 64] | bit : words_[index / 64] & ~bit;
}

double SimilarityOf(double disagreement, int bits) { return 1 / (2 * std::max(disagreement, 0.5 / bits)); }

// ---------------------------------------------------------------------------------------------------------------------

/// Row r, column p: mean of the smoothed image over the half square whose upper left corner lies at row r square / 2,
/// column p shift_px.
struct WaveletEncoder::Smoothed {
  Eigen::MatrixXf means;  // against the image's first pixel
  float no_detail = 0;
};

WaveletEncoder::WaveletEncoder(int height_px, const WaveletOptions& options)
    : options_(options), height_px_(height_px), rows_(height_px / options.square_px()) {
  CheckFields(options, "wavelet.");
  const int square = options.square_px();
  if (rows_ < 1) {
    throw BadInput("wavelet signature: an image " + std::to_string(height_px) + " px high is too small for level " +
                   std::to_string(options.level) + ", which needs " + std::to_string(square) + " px");
  }
  const double sigma = options.prefilter * square;  // 4.4.2, see there
  const int across = options.shift_px(), down = square / kDownParts;
  const double sigma_across = RestSigma(sigma, across), sigma_down = RestSigma(sigma, down);
  across_ = FilteredMean(sigma_across, square / 2 / across, RadiusOf(sigma_across));

  const int radius = RadiusOf(sigma_down), run = kDownParts / 2, averaged = rows_ * kDownParts;
  const std::vector<float> weights = FilteredMean(sigma_down, run, radius);
  down_ = cv::Mat::zeros(2 * rows_, averaged, CV_32F);
  for (int half = 0; half < 2 * rows_; ++half) {
    for (size_t k = 0; k < weights.size(); ++k) {
      const int from = std::clamp(half * run + int(k) - radius, 0, averaged - 1);  // border pixels go on outside
      down_.at<float>(half, from) += weights[k];
    }
  }
}

void WaveletEncoder::CheckImage(const cv::Mat& image, const char* what) const {
  if (image.type() != CV_8UC1) throw BadInput(std::string("wavelet signature: the ") + what + " must be 8 bit grey");
  if (image.rows != height_px_) {
    throw BadInput(std::string("wavelet signature: the ") + what + " is " + std::to_string(image.rows) + " px high; " +
                   std::to_string(height_px_) + " px are expected");
  }
}

WaveletEncoder::Smoothed WaveletEncoder::Smooth(const cv::Mat& image, bool circular) const {
  const int across = options_.shift_px(), down = options_.square_px() / kDownParts;
  const int width = image.cols / across, height = rows_ * kDownParts;
  // Averages, rows of the image as columns' entries: column-major with the image's columns as columns.
  Eigen::MatrixXf averaged(height, width);
  std::vector<int> sums(size_t(width), 0);
  for (int y = 0; y < height; ++y) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int row = y * down; row < (y + 1) * down; ++row) {
      const uchar* pixel = image.ptr<uchar>(row);
      for (int x = 0; x < width; ++x) {
        for (int k = 0; k < across; ++k) sums[size_t(x)] += pixel[x * across + k];
      }
    }
    for (int x = 0; x < width; ++x) averaged(y, x) = float(sums[size_t(x)]) / float(across * down);
  }
  averaged.array() -= averaged(0, 0);  // exact: light added everywhere changes no bit of what follows
  const float no_detail = kNoDetail * (averaged.maxCoeff() - averaged.minCoeff());
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> down_filter(down_.ptr<float>(), down_.rows, down_.cols);

  const int run = options_.square_px() / 2 / across, radius = (int(across_.size()) - run) / 2;
  Eigen::MatrixXf padded(2 * rows_, width + 2 * radius);
  padded.middleCols(radius, width).noalias() = down_filter * averaged;
  for (int k = 1; k <= radius; ++k) {
    padded.col(radius - k) = padded.col(radius + (circular ? (width - k % width) % width : 0));
    padded.col(radius + width - 1 + k) = padded.col(radius + (circular ? (k - 1) % width : width - 1));
  }
  const int positions = width - run + 1;
  Smoothed smoothed{Eigen::MatrixXf::Zero(2 * rows_, positions), no_detail};
  for (size_t k = 0; k < across_.size(); ++k) smoothed.means += across_[k] * padded.middleCols(int(k), positions);
  return smoothed;
}

WaveletSignature WaveletEncoder::Signs(const Smoothed& smoothed, int first, int columns) const {
  WaveletSignature signature(columns, rows_);
  const int square = WaveletOptions::kShifts, half = square / 2;
  const auto sign = [&](float coefficient) { return coefficient >= -smoothed.no_detail; };
  for (int column = 0; column < columns; ++column) {
    const int left = first + square * column, right = left + half;
    for (int row = 0; row < rows_; ++row) {
      const float a = smoothed.means(2 * row, left), b = smoothed.means(2 * row, right);
      const float c = smoothed.means(2 * row + 1, left), d = smoothed.means(2 * row + 1, right);
      signature.Set(WaveletSignature::kHorizontal, row, column, sign((a + b) - (c + d)));
      signature.Set(WaveletSignature::kVertical, row, column, sign((a + c) - (b + d)));
      signature.Set(WaveletSignature::kDiagonal, row, column, sign((a + d) - (b + c)));
    }
  }
  return signature;
}

WaveletSignature WaveletEncoder::OfPanorama(const cv::Mat& panorama) const {
  CheckImage(panorama, "panorama");
  const int columns = panorama.cols / options_.square_px();
  if (columns < 1) {
    throw BadInput("wavelet signature: a panorama " + std::to_string(panorama.cols) +
                   " px wide is too small for level " + std::to_string(options_.level));
  }
  cv::Mat whole = panorama;
  const int width = columns * options_.square_px();
  if (width != panorama.cols) cv::resize(panorama, whole, {width, panorama.rows}, 0, 0, cv::INTER_LINEAR);
  return Signs(Smooth(whole, true), 0, columns);
}

WaveletView WaveletEncoder::OfView(const cv::Mat& view) const {
  CheckImage(view, "view");
  const int square = options_.square_px(), dropped = square - options_.shift_px();
  const int columns = (view.cols - dropped) / square;
  if (columns < 1) {
    throw BadInput("wavelet signature: a view " + std::to_string(view.cols) + " px wide is too small for level " +
                   std::to_string(options_.level) + ", which needs " + std::to_string(square + dropped) + " px");
  }
  const Smoothed smoothed = Smooth(view, false);
  WaveletView result;
  result.width_px = view.cols;
  for (int shift = 0; shift < WaveletOptions::kShifts; ++shift)
    result.shifts.push_back(Signs(smoothed, shift, columns));
  return result;
}

// ---------------------------------------------------------------------------------------------------------------------

void WaveletMap::Add(const WaveletSignature& panorama) {
  if (places_ == 0) {
    columns_ = panorama.columns();
    rows_ = panorama.rows();
    bytes_ = panorama.bytes();
  }
  if (panorama.empty() || panorama.columns() != columns_ || panorama.rows() != rows_) {
    throw BadInput("wavelet map: a panorama of " + std::to_string(panorama.columns()) + " x " +
                   std::to_string(panorama.rows()) + " squares among those of " + std::to_string(columns_) + " x " +
                   std::to_string(rows_));
  }
  packed_.resize((places_ + 1) * bytes_);
  std::memcpy(&packed_[places_ * bytes_], panorama.words().data(), bytes_);
  ++places_;
}

void WaveletMap::CheckView(const WaveletView& view) const {
  if (places_ == 0) throw BadInput("wavelet map: it is empty, there is nothing to compare a view with");
  GAITCAM_ASSERT(view.shifts.size() == WaveletOptions::kShifts);
  const WaveletSignature& first = view.shifts.front();
  if (first.rows() != rows_) {
    throw BadInput("wavelet map: a view of " + std::to_string(first.rows()) + " squares high, panoramas of " +
                   std::to_string(rows_));
  }
  if (first.columns() > columns_) {
    throw BadInput("wavelet map: the panoramas, " + std::to_string(columns_) +
                   " squares wide, are narrower than the view, " + std::to_string(first.columns()));
  }
  GAITCAM_ASSERT(first.words().size() <= kMostWords);
}

std::vector<WaveletMatch> WaveletMap::Query(const WaveletView& view) const {
  CheckView(view);
  const Probe probe = ProbeOf(view);
  const FitFunction fit = FitFor(options_);
  Ring ring(size_t(columns_) * size_t(3 * rows_), probe.bits);
  std::vector<WaveletMatch> matches;
  matches.reserve(places_);
  for (size_t place = 0; place < places_; ++place) {
    const uint64_t* words = ring.Load(&packed_[place * bytes_], bytes_);
    matches.push_back(MatchOf(fit(words, columns_, 3 * rows_, {0, columns_}, probe, options_), probe, options_));
  }
  return matches;
}

WaveletMatch WaveletMap::Query(const WaveletView& view, size_t place, std::optional<WaveletWindow> window) const {
  CheckView(view);
  GAITCAM_ASSERT(place < places_);
  Columns searched{0, columns_};
  if (window) {
    const double square = options_.square_px();
    const int first = int(std::floor((window->left_px - window->tolerance_px) / square));
    const int last = int(std::ceil((window->left_px + window->tolerance_px) / square));
    if (last - first + 1 < columns_) searched = {((first % columns_) + columns_) % columns_, last - first + 1};
  }
  const Probe probe = ProbeOf(view);
  Ring ring(size_t(columns_) * size_t(3 * rows_), probe.bits);
  const uint64_t* words = ring.Load(&packed_[place * bytes_], bytes_);
  return MatchOf(FitFor(options_)(words, columns_, 3 * rows_, searched, probe, options_), probe, options_);
}

}  // namespace gaitcam
