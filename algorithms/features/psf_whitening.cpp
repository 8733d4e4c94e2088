#include "algorithms/features/psf_whitening.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kMinWhiteningSide = 32;

float Bilinear(const cv::Mat& image, float x, float y) {
  const int x0 = int(x), y0 = int(y);
  const float a = x - float(x0), b = y - float(y0);
  const float* top = image.ptr<float>(y0) + x0;
  const float* bottom = image.ptr<float>(y0 + 1) + x0;
  return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
}

/// Where the minimum of a parabola through three equidistant values lies, relative to the middle one.
double ParabolaOffset(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature > 0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0;
}

/// The image turned by -direction about its centre, so that the blur runs along x, and which pixels of it were seen.
struct TurnedImage {
  cv::Mat grey;  ///< CV_32FC1
  cv::Mat seen;  ///< CV_8UC1
};

TurnedImage Turn(const cv::Mat& grey, const cv::Mat& mask, double direction_rad) {
  const int side = int(std::ceil(std::hypot(grey.cols, grey.rows)));
  const double c = std::cos(direction_rad), s = std::sin(direction_rad);
  const double middle = 0.5 * (side - 1), cx = 0.5 * (grey.cols - 1), cy = 0.5 * (grey.rows - 1);
  // Maps pixels of the turned image to those of the original.
  const cv::Matx23d back(c, -s, cx - c * middle + s * middle, s, c, cy - s * middle - c * middle);
  TurnedImage turned;
  const cv::Mat seen = mask.empty() ? cv::Mat(grey.size(), CV_8UC1, cv::Scalar(255)) : mask;
  cv::warpAffine(grey, turned.grey, back, {side, side}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::warpAffine(seen, turned.seen, back, {side, side}, cv::INTER_NEAREST | cv::WARP_INVERSE_MAP);
  cv::erode(turned.seen, turned.seen, cv::Mat::ones(3, 3, CV_8UC1), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  return turned;
}

/// Equation 5.3, summed over all lines of the turned image; derivatives outside of what was seen are 0.
std::vector<double> AutoCorrelation(const TurnedImage& turned, int max_lag) {
  const int width = turned.grey.cols;
  std::vector<double> sum(size_t(max_lag) + 1, 0.0);
  std::vector<float> line(size_t(width + max_lag), 0.0f);
  for (int y = 0; y < turned.grey.rows; ++y) {
    const float* g = turned.grey.ptr<float>(y);
    const uchar* seen = turned.seen.ptr<uchar>(y);
    int derivatives = 0;
    for (int x = 0; x + 1 < width; ++x) {
      const bool both = seen[x] && seen[x + 1];
      line[size_t(x)] = both ? g[x + 1] - g[x] : 0.0f;
      derivatives += both;
    }
    if (derivatives <= max_lag / 2) continue;  // too short a line to say anything of long lags
    for (int j = 0; j <= max_lag; ++j) {
      float dot = 0;
      const float* shifted = line.data() + j;
      for (int x = 0; x < width; ++x) dot += line[size_t(x)] * shifted[x];
      sum[size_t(j)] += double(dot);
    }
  }
  return sum;
}

std::vector<double> Smooth(const std::vector<double>& values) {
  std::vector<double> smooth = values;
  for (size_t i = 1; i + 1 < values.size(); ++i) smooth[i] = 0.25 * (values[i - 1] + 2 * values[i] + values[i + 1]);
  return smooth;
}

}  // namespace

std::vector<double> DirectionalDerivatives(const cv::Mat& grey, const cv::Rect& region, int bins, int step_px) {
  GAITCAM_ASSERT(grey.type() == CV_32FC1 && bins > 0 && step_px > 0);
  std::vector<double> sums(size_t(bins), 0.0);
  const int left = std::max(region.x, 1), top = std::max(region.y, 1);
  const int right = std::min(region.br().x, grey.cols - 2), bottom = std::min(region.br().y, grey.rows - 2);
  for (int b = 0; b < bins; ++b) {
    const float dx = float(std::cos(M_PI * b / bins)), dy = float(std::sin(M_PI * b / bins));
    for (int y = top; y < bottom; y += step_px) {
      for (int x = left; x < right; x += step_px) {
        sums[size_t(b)] += double(std::abs(Bilinear(grey, float(x) + dx, float(y) + dy) - grey.at<float>(y, x)));
      }
    }
  }
  return sums;
}

double LeastDirection(const std::vector<double>& bins) {
  const int n = int(bins.size());
  const int least = int(std::min_element(bins.begin(), bins.end()) - bins.begin());
  const auto at = [&](int i) { return bins[size_t((i + n) % n)]; };
  const double bin = least + ParabolaOffset(at(least - 1), at(least), at(least + 1));
  const double direction = std::fmod(bin * M_PI / n + M_PI, M_PI);
  return direction;
}

WhiteningPsf::WhiteningPsf(const WhiteningOptions& options) : options_(options) { CheckFields(options_); }

BlurEstimate WhiteningPsf::EstimateExtent(const cv::Mat& grey, const cv::Mat& mask, double direction_rad) const {
  cv::Mat values;
  grey.convertTo(values, CV_32F);
  const std::vector<double> acf =
      Smooth(AutoCorrelation(Turn(values, mask, direction_rad), options_.max_extent_px + 1));
  BlurEstimate estimate;
  estimate.blur.direction_rad = direction_rad;
  if (!(acf[0] > 0)) return estimate;  // no texture
  const auto begin = acf.begin() + options_.min_extent_px;
  const auto least = std::min_element(begin, acf.end() - 1);
  if (*least >= 0) return estimate;
  estimate.blur.extent_px = double(least - acf.begin()) + ParabolaOffset(*(least - 1), *least, *(least + 1));
  estimate.confidence = std::min(1.0, -2 * *least / acf[0]);
  estimate.blurred = estimate.blur.extent_px >= options_.verdict_px && estimate.confidence >= options_.min_confidence;
  return estimate;
}

BlurEstimate WhiteningPsf::Estimate(const cv::Mat& grey, const cv::Rect& region) const {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  const cv::Rect seen = region & cv::Rect({0, 0}, grey.size());
  if (seen.width < kMinWhiteningSide || seen.height < kMinWhiteningSide) return {};
  cv::Mat values;
  grey(seen).convertTo(values, CV_32F);
  const std::vector<double> bins =
      DirectionalDerivatives(values, {{0, 0}, seen.size()}, options_.directions, options_.sample_step_px);
  return EstimateExtent(grey(seen), cv::Mat(), LeastDirection(bins));
}

}  // namespace gaitcam
