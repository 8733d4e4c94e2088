#include "algorithms/places/wavelet_signature.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

namespace gaitcam {
namespace {

constexpr float kNoDetail = 1e-5f;  // of the image's range: rounding errors of a coefficient that is 0
constexpr int kDownParts = 4;       // pixels are averaged by square / kDownParts down the image

/// Not normalised.
double Gaussian(double x, double sigma) { return std::exp(-0.5 * x * x / (sigma * sigma)); }

/// Sigma of the filter for pixels averaged by `factor`, in such pixels: averaging has a variance of (factor^2 - 1)
/// / 12.
double RemainingSigma(double sigma, int factor) {
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
  const double sigma_across = RemainingSigma(sigma, across), sigma_down = RemainingSigma(sigma, down);
  across_ = FilteredMean(sigma_across, square / 2 / across, RadiusOf(sigma_across));

  const int radius = RadiusOf(sigma_down), run = kDownParts / 2, averaged = rows_ * kDownParts;
  const std::vector<float> weights = FilteredMean(sigma_down, run, radius);
  down_ = cv::Mat::zeros(2 * rows_, averaged, CV_32F);
  for (int half = 0; half < 2 * rows_; ++half) {
    for (size_t k = 0; k < weights.size(); ++k) {
      const int from = std::clamp(half * run + int(k) - radius, 0, averaged - 1);  // border pixels are repeated
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
  averaged.array() -= averaged(0, 0);  // exact: a constant offset of the brightness changes no bit of the result
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

}  // namespace gaitcam
