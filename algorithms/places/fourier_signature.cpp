#include "algorithms/places/fourier_signature.h"

#include <algorithm>
#include <cmath>

#include "algorithms/places/place_recognition.h"

namespace gaitcam {
namespace {

constexpr int kWindowStep_px = 16;
constexpr double kMinDistance = 1e-6;  // of equal signatures, so that similarity stays finite

class FourierIndex : public PlaceIndex {
 public:
  FourierIndex(const PlaceIndexSetup& setup, FourierScope scope)
      : layout_(setup.layout), view_width_px_(setup.view_width_px), scope_(scope) {}

  void Add(const cv::Mat& panorama) override {
    internal::CheckPlaceImage(panorama, layout_.width_px, layout_.height_px, "panorama");
    places_.push_back(scope_ == FourierScope::kWhole ? OfWhole(panorama) : OfWindows(panorama));
  }

  std::vector<PlaceMatch> Query(const cv::Mat& view) const override {
    internal::CheckPlaceImage(view, view_width_px_, layout_.height_px, "view");
    if (places_.empty()) throw BadInput("places: the index is empty, there is nothing to compare a view with");
    const std::vector<float> signature = Scaled(FourierSignature(view));
    std::vector<PlaceMatch> matches;
    for (const std::vector<std::vector<float>>& windows : places_) {
      size_t best = 0;
      double min_distance = 1e300;
      for (size_t k = 0; k < windows.size(); ++k) {
        const double distance = FourierDistance(windows[k], signature);
        if (distance < min_distance) min_distance = distance, best = k;
      }
      const double left_px = double(best) * kWindowStep_px;
      matches.push_back({1 / std::max(min_distance, kMinDistance),
                         scope_ == FourierScope::kWhole ? 0 : internal::BearingOf(layout_, left_px, view.cols)});
    }
    return matches;
  }

  size_t size() const override { return places_.size(); }
  double bytes_per_place() const override {
    return places_.empty() ? 0 : double(places_[0].size() * places_[0][0].size() * sizeof(float));
  }

 private:
  std::vector<std::vector<float>> OfWindows(const cv::Mat& panorama) const {
    const cv::Mat twice = cv::repeat(panorama, 1, 2);
    std::vector<std::vector<float>> windows;
    for (int left = 0; left < layout_.width_px; left += kWindowStep_px)
      windows.push_back(FourierSignature(twice.colRange(left, left + view_width_px_)));
    return windows;
  }

  /// Coefficient k of a view has the frequency of coefficient k (panorama width / view width) of the panorama: the root
  /// mean square of the panorama's coefficients in that band.
  std::vector<std::vector<float>> OfWhole(const cv::Mat& panorama) const {
    const double ratio = double(layout_.width_px) / view_width_px_;
    const int last = int(std::ceil((kFourierCoefficients + 0.5) * ratio));
    const std::vector<float> fine = FourierSignature(panorama, std::min(last, layout_.width_px / 2));
    std::vector<float> coarse;
    for (int k = 1; k <= kFourierCoefficients; ++k) {
      const size_t from = size_t(std::lround((k - 0.5) * ratio)), to = size_t(std::lround((k + 0.5) * ratio));
      double power = 0;
      size_t count = 0;
      for (size_t j = std::max<size_t>(from, 1); j < to && j <= fine.size(); ++j, ++count)
        power += double(fine[j - 1]) * fine[j - 1];
      coarse.push_back(float(count ? std::sqrt(power / double(count)) : 0));
    }
    return {Scaled(coarse)};
  }

  /// A section and the whole have different mean and standard deviation: only the spectrum's shape is compared.
  std::vector<float> Scaled(std::vector<float> signature) const {
    if (scope_ != FourierScope::kWhole) return signature;
    float sum = 0;
    for (const float value : signature) sum += value;
    for (float& value : signature) value /= std::max(sum, 1e-12f);
    return signature;
  }

  PanoramaLayout layout_;
  int view_width_px_;
  FourierScope scope_;
  std::vector<std::vector<std::vector<float>>> places_;  // windows of each
};

}  // namespace

std::vector<float> FourierSignature(const cv::Mat& image, int coefficients) {
  cv::Mat row, spectrum;
  cv::reduce(image, row, 0, cv::REDUCE_AVG, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(row, mean, deviation);
  row = (row - mean[0]) / std::max(deviation[0], 1e-6);
  cv::dft(row, spectrum, cv::DFT_COMPLEX_OUTPUT);
  std::vector<float> magnitudes(size_t(coefficients), 0.0f);
  const float scale = 1 / std::sqrt(float(image.cols));
  for (int k = 1; k <= coefficients && k < image.cols; ++k) {
    const auto value = spectrum.at<cv::Vec2f>(0, k);
    magnitudes[size_t(k - 1)] = scale * std::hypot(value[0], value[1]);
  }
  return magnitudes;
}

double FourierDistance(const std::vector<float>& a, const std::vector<float>& b) {
  GAITCAM_ASSERT(a.size() == b.size());
  double sum = 0;
  for (size_t k = 0; k < a.size(); ++k) sum += std::abs(a[k] - b[k]);
  return sum;
}

std::unique_ptr<PlaceIndex> MakeFourierIndex(const PlaceIndexSetup& setup, FourierScope scope) {
  return std::make_unique<FourierIndex>(setup, scope);
}

}  // namespace gaitcam
