#include "algorithms/places/place_recognition.h"

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "algorithms/places/fourier_signature.h"
#include "algorithms/places/orb_words.h"
#include "algorithms/places/thumbnail.h"

namespace gaitcam {
namespace internal {

void CheckPlaceImage(const cv::Mat& image, int width_px, int height_px, const char* what) {
  if (image.type() != CV_8UC1) throw BadInput(std::string("places: a ") + what + " must be 8 bit grey");
  if (image.cols == width_px && image.rows == height_px) return;
  throw BadInput(std::string("places: a ") + what + " of " + std::to_string(image.cols) + " x " +
                 std::to_string(image.rows) + " px; " + std::to_string(width_px) + " x " + std::to_string(height_px) +
                 " px are expected");
}

double BearingOf(const PanoramaLayout& layout, double left_px, int view_width_px) {
  return std::remainder(layout.AzimuthOf(left_px + 0.5 * (view_width_px - 1)), 2 * std::numbers::pi);
}

}  // namespace internal

namespace {

class WaveletIndex : public PlaceIndex {
 public:
  explicit WaveletIndex(const PlaceIndexSetup& setup)
      : layout_(setup.layout),
        view_width_px_(setup.view_width_px),
        encoder_(setup.layout.height_px, setup.wavelet),
        map_(setup.wavelet) {}

  void Add(const cv::Mat& panorama) override {
    internal::CheckPlaceImage(panorama, layout_.width_px, layout_.height_px, "panorama");
    map_.Add(encoder_.OfPanorama(panorama));
  }
  std::vector<PlaceMatch> Query(const cv::Mat& view) const override {
    internal::CheckPlaceImage(view, view_width_px_, layout_.height_px, "view");
    std::vector<PlaceMatch> matches;
    for (const WaveletMatch& match : map_.Query(encoder_.OfView(view)))
      matches.push_back({match.similarity, internal::BearingOf(layout_, match.left_px, view.cols)});
    return matches;
  }
  size_t size() const override { return map_.size(); }
  double bytes_per_place() const override { return double(map_.bytes_per_place()); }

 private:
  PanoramaLayout layout_;
  int view_width_px_;
  WaveletEncoder encoder_;
  WaveletMap map_;
};

using Maker = std::function<std::unique_ptr<PlaceIndex>(const PlaceIndexSetup&)>;

/// Every method there is: a new one is one more line here.
std::map<std::string, Maker> AllMethods() {
  return {
      {"wavelet", [](const auto& setup) { return std::make_unique<WaveletIndex>(setup); }},
      {"fourier", [](const auto& setup) { return MakeFourierIndex(setup, FourierScope::kWindows); }},
      {"fourier_whole", [](const auto& setup) { return MakeFourierIndex(setup, FourierScope::kWhole); }},
      {"thumbnail", [](const auto& setup) { return MakeThumbnailIndex(setup); }},
      {"orb_words", [](const auto& setup) { return MakeOrbWordsIndex(setup); }},
  };
}

}  // namespace

std::vector<std::string> PlaceIndexNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : AllMethods()) names.push_back(name);
  return names;
}

std::unique_ptr<PlaceIndex> MakePlaceIndex(const std::string& name, const PlaceIndexSetup& setup) {
  const std::map<std::string, Maker> methods = AllMethods();
  const auto method = methods.find(name);
  if (method == methods.end()) {
    throw BadInput("places: there is no method " + name + "; " + DidYouMean(name, PlaceIndexNames()));
  }
  setup.layout.Check();
  if (setup.view_width_px < 1 || setup.view_width_px > setup.layout.width_px) {
    throw BadInput("places: the panoramas, " + std::to_string(setup.layout.width_px) +
                   " px wide, are narrower than the view, " + std::to_string(setup.view_width_px) + " px");
  }
  return method->second(setup);
}

}  // namespace gaitcam
