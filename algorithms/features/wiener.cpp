#include "algorithms/features/wiener.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// H W = H^2 / (H^2 + gamma): the blurred image that the restored one explains.
class ExplainedTransfer : public TransferFunction {
 public:
  ExplainedTransfer(const LineBlur& blur, const WienerOptions& options) : line_(blur), wiener_(blur, options) {}
  void Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const override {
    Eigen::ArrayXf h(fx.size());
    line_.Row(fx, fy, h);
    wiener_.Row(fx, fy, out);
    out *= h;
  }

 private:
  LineTransfer line_;
  WienerTransfer wiener_;
};

}  // namespace

WienerTransfer::WienerTransfer(const LineBlur& blur, const WienerOptions& options)
    : line_(blur), gamma_(float(options.gamma)), slope_(float(options.gamma_slope)) {
  CheckFields(options);
}

void WienerTransfer::Row(const Eigen::ArrayXf& fx, float fy, Eigen::Ref<Eigen::ArrayXf> out) const {
  line_.Row(fx, fy, out);
  out = out / (out.square() + (gamma_ + slope_ * (fx.square() + fy * fy)));
}

namespace {

constexpr int kMinMargin_px = 32;  // room for the margin to fade

/// How far light was carried, px.
double Reach(const BlurRegion& region) {
  if (region.path.empty()) return region.estimate.blur.extent_px;
  double reach = 0;
  for (const Eigen::Vector2d& p : region.path.points) reach = std::max(reach, (p - region.path.points.front()).norm());
  return reach;
}

}  // namespace

cv::Mat RestoreWiener(const cv::Mat& image, const LineBlur& blur, const WienerOptions& options) {
  const int margin = std::max(kMinMargin_px, int(std::ceil(blur.extent_px)));
  Spectrum spectrum(image, margin);
  const ExplainedTransfer explained(blur, options);
  for (int pass = 0; pass < options.border_passes; ++pass) spectrum.RefillMargin(explained);
  return spectrum.Through(WienerTransfer(blur, options));
}

cv::Mat RestoreWiener(const cv::Mat& image, const BlurPath& path, const WienerOptions& options) {
  CheckFields(options);
  const int margin = std::max(kMinMargin_px, int(std::ceil(Reach({{}, {}, path}))));
  Spectrum spectrum(image, margin);
  const cv::Size plane = spectrum.plane_size();
  const PlaneGain H = PathTransfer(path, plane);
  PlaneGain wiener = H.conjugate();
  for (long y = 0; y < wiener.rows(); ++y) {
    const float fy = float(y <= plane.height / 2 ? y : y - plane.height) / float(plane.height);
    for (long x = 0; x < wiener.cols(); ++x) {
      const float fx = float(x) / float(plane.width);
      wiener(y, x) /= std::norm(H(y, x)) + float(options.gamma) + float(options.gamma_slope) * (fx * fx + fy * fy);
    }
  }
  for (int pass = 0; pass < options.border_passes; ++pass) spectrum.RefillMargin(PlaneGain(wiener * H));
  return spectrum.Through(wiener);
}

namespace {

cv::Mat RestoreOne(const cv::Mat& image, const BlurRegion& region, const WienerOptions& options) {
  return region.path.empty() ? RestoreWiener(image, region.estimate.blur, options)
                             : RestoreWiener(image, region.path, options);
}

/// 1 inside the region, falling to 0 at kSeam_px beyond its border: weights of neighbours that add up to 1.
double Weight(const cv::Rect& region, int x, int y) {
  const auto ramp = [](int inside) {  // pixels from the border to the inside, counted from the first
    return std::clamp((inside + kSeam_px + 0.5) / (2 * kSeam_px), 0.0, 1.0);
  };
  return ramp(x - region.x) * ramp(region.br().x - 1 - x) * ramp(y - region.y) * ramp(region.br().y - 1 - y);
}

}  // namespace

cv::Mat RestoreRegions(const cv::Mat& image, const std::vector<BlurRegion>& regions, const WienerOptions& options) {
  if (regions.size() == 1 && regions.front().estimate.blurred) return RestoreOne(image, regions.front(), options);
  cv::Mat sum = cv::Mat::zeros(image.size(), CV_32FC1), weights = cv::Mat::zeros(image.size(), CV_32FC1);
  const cv::Rect whole({0, 0}, image.size());
  for (const BlurRegion& region : regions) {
    const auto grown = [&](int by) {
      return (region.rectangle + cv::Size(2 * by, 2 * by) - cv::Point(by, by)) & whole;
    };
    const bool blurred = region.estimate.blurred;
    const cv::Rect used = grown(kSeam_px);
    const cv::Rect seen = blurred ? grown(kSeam_px + int(std::ceil(Reach(region)))) : used;
    const cv::Mat part = blurred ? RestoreOne(image(seen), region, options) : image(seen);
    for (int y = used.y; y < used.br().y; ++y)
      for (int x = used.x; x < used.br().x; ++x) {
        const float weight = float(Weight(region.rectangle, x, y));
        sum.at<float>(y, x) += weight * part.at<float>(y - seen.y, x - seen.x);
        weights.at<float>(y, x) += weight;
      }
  }
  return sum / weights;
}

}  // namespace gaitcam
