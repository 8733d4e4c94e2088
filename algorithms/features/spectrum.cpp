#include "algorithms/features/spectrum.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr float kPiF = float(M_PI);

constexpr int kUnit = 1 << Spectrum::kMaxOctave;

/// The least length that the transform is fast at and that halves kMaxOctave times.
int FastLength(int least) {
  int n = (least + kUnit - 1) / kUnit * kUnit;
  while (cv::getOptimalDFTSize(n) != n) n += kUnit;
  return n;
}

/// 1 over the image and the nearer part of the margin, falling to 0 at the plane's ends.
std::vector<float> Fade(int length, int begin, int end) {
  constexpr float kFading = 0.6f;  // part of the margin over which it falls
  std::vector<float> fade(size_t(length), 1.f);
  const auto fall = [&](int to_end, int margin) {
    const float t = float(to_end) / (kFading * float(margin));
    return t >= 1 ? 1.f : 0.5f - 0.5f * std::cos(kPiF * t);
  };
  for (int i = 0; i < begin; ++i) fade[size_t(i)] = fall(i, begin);
  for (int i = end; i < length; ++i) fade[size_t(i)] = fall(length - 1 - i, length - end);
  return fade;
}

}  // namespace

void LineTransfer::Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const {
  constexpr float kNearZero = 1e-4f;
  const float offset = kPiF * vector_.y() * fy;
  out = (fx * (kPiF * vector_.x()) + offset).abs().max(kNearZero);
  out = out.sin() / out;
}

GaussianTransfer::GaussianTransfer(double sigma_along, double sigma_across, double direction_rad) {
  const double c = std::cos(direction_rad), s = std::sin(direction_rad), k = -2 * M_PI * M_PI;
  const double along = k * sigma_along * sigma_along, across = k * sigma_across * sigma_across;
  xx_ = float(along * c * c + across * s * s);
  yy_ = float(along * s * s + across * c * c);
  xy_ = float((along - across) * c * s);
}

void GaussianTransfer::Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const {
  out = ((xx_ * fx + 2 * xy_ * fy) * fx + yy_ * fy * fy).exp();
}

Spectrum::Spectrum(const cv::Mat& image, int margin_px) : image_(image) {
  GAITCAM_ASSERT(image.type() == CV_32FC1 && !image.empty() && margin_px >= 0);
  plane_ = {FastLength(image.cols + 2 * std::max(margin_px, kUnit)),
            FastLength(image.rows + 2 * std::max(margin_px, kUnit))};
  const auto corner = [](int plane, int size) { return (plane - size) / 2 / kUnit * kUnit; };
  place_ = cv::Rect({corner(plane_.width, image.cols), corner(plane_.height, image.rows)}, image.size());
  cv::Mat plane;
  cv::copyMakeBorder(image, plane, place_.y, plane_.height - place_.br().y, place_.x, plane_.width - place_.br().x,
                     cv::BORDER_REFLECT_101);
  const float mean = float(cv::mean(image)[0]);
  const std::vector<float> across = Fade(plane_.width, place_.x, place_.br().x);
  const std::vector<float> down = Fade(plane_.height, place_.y, place_.br().y);
  for (int y = 0; y < plane.rows; ++y) {
    float* row = plane.ptr<float>(y);
    for (int x = 0; x < plane.cols; ++x) row[x] = mean + (row[x] - mean) * across[size_t(x)] * down[size_t(y)];
  }
  cv::dft(plane, transform_, cv::DFT_COMPLEX_OUTPUT);
}

cv::Mat Spectrum::Plane(const TransferFunction& transfer, int octave) const {
  GAITCAM_ASSERT(octave >= 0 && octave <= kMaxOctave);
  const int width = plane_.width >> octave, height = plane_.height >> octave, half = width / 2 + 1;
  cv::Mat product(height, width, CV_32FC2);  // the inverse of a real image reads the left half only
  const Eigen::ArrayXf fx = Eigen::ArrayXf::LinSpaced(half, 0, float(half - 1)) / float(plane_.width);
  Eigen::ArrayXf gain(half);
  const float scale = 1 / (float(plane_.width) * float(plane_.height));
  for (int y = 0; y < height; ++y) {
    const int v = y <= height / 2 ? y : y - height;  // signed frequency
    transfer.Row(fx, float(v) / float(plane_.height), gain);
    gain *= scale;
    const float* from = transform_.ptr<float>(v >= 0 ? v : plane_.height + v);
    float* to = product.ptr<float>(y);
    for (int x = 0; x < half; ++x) {
      to[2 * x] = from[2 * x] * gain[x];
      to[2 * x + 1] = from[2 * x + 1] * gain[x];
    }
  }
  cv::Mat plane;
  cv::dft(product, plane, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
  return plane;
}

cv::Mat Spectrum::Through(const TransferFunction& transfer, int octave) const {
  const cv::Mat plane = Plane(transfer, octave);
  const cv::Rect part(place_.x >> octave, place_.y >> octave, ((place_.width - 1) >> octave) + 1,
                      ((place_.height - 1) >> octave) + 1);
  return plane(part);
}

void Spectrum::RefillMargin(const TransferFunction& transfer) { ReplaceMargin(Plane(transfer, 0)); }

void Spectrum::ReplaceMargin(const cv::Mat& plane) {
  image_.copyTo(plane(place_));
  cv::dft(plane, transform_, cv::DFT_COMPLEX_OUTPUT);
}

cv::Mat Spectrum::Plane(const PlaneGain& gain) const {
  const int half = plane_.width / 2 + 1;
  GAITCAM_ASSERT(gain.rows() == plane_.height && gain.cols() == half);
  cv::Mat product(plane_, CV_32FC2), plane;
  const float scale = 1 / (float(plane_.width) * float(plane_.height));
  for (int y = 0; y < plane_.height; ++y) {
    const auto* from = transform_.ptr<std::complex<float>>(y);
    auto* to = product.ptr<std::complex<float>>(y);
    for (int x = 0; x < half; ++x) to[x] = scale * from[x] * gain(y, x);
  }
  cv::dft(product, plane, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
  return plane;
}

cv::Mat Spectrum::Through(const PlaneGain& gain) const { return Plane(gain)(place_); }

void Spectrum::RefillMargin(const PlaneGain& gain) { ReplaceMargin(Plane(gain)); }

}  // namespace gaitcam
