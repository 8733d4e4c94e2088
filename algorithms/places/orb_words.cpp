#include "algorithms/places/orb_words.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>

#include "algorithms/places/place_recognition.h"
#include "algorithms/places/visual_words.h"

namespace gaitcam {
namespace {

constexpr int kWords = 256;
constexpr int kMaxTrainingDescriptors = 20000;
constexpr int kFeaturesPerPanorama = 800;  // and as many per width in views
constexpr int kWordWindowStep_px = 16;

struct Feature {
  uint16_t word = 0;
  uint16_t column = 0;
};

class OrbWordsIndex : public PlaceIndex {
 public:
  explicit OrbWordsIndex(const PlaceIndexSetup& setup) : layout_(setup.layout), view_width_px_(setup.view_width_px) {
    if (setup.training.empty()) throw BadInput("places: orb_words needs images to learn its words from");
    Train(setup.training, setup.seed);
  }

  void Add(const cv::Mat& panorama) override {
    internal::CheckPlaceImage(panorama, layout_.width_px, layout_.height_px, "panorama");
    // Unrolled beyond 360 degrees by a window, so that features at the seam are found as elsewhere.
    Place place{Features(cv::repeat(panorama, 1, 2).colRange(0, layout_.width_px + view_width_px_)), {}};
    std::sort(place.features.begin(), place.features.end(),
              [](const Feature& a, const Feature& b) { return a.column < b.column; });
    for (int left = 0; left < layout_.width_px; left += kWordWindowStep_px) {
      std::vector<double> vector(kWords, 0.0);
      for (const Feature& feature : place.features) {
        if (feature.column >= left && feature.column < left + view_width_px_)
          vector[feature.word] += idf_[feature.word];
      }
      place.norms.push_back(float(cv::norm(vector)));
    }
    places_.push_back(place);
  }

  std::vector<PlaceMatch> Query(const cv::Mat& view) const override {
    internal::CheckPlaceImage(view, view_width_px_, layout_.height_px, "view");
    if (places_.empty()) throw BadInput("places: the index is empty, there is nothing to compare a view with");
    std::vector<double> vector(kWords, 0.0);
    for (const Feature& feature : Features(view)) vector[feature.word] += idf_[feature.word];
    const double norm = std::max(cv::norm(vector), 1e-12);
    std::vector<PlaceMatch> matches;
    for (const Place& place : places_) matches.push_back(BestWindow(place, vector, norm));
    return matches;
  }

  size_t size() const override { return places_.size(); }
  /// Of features that lie within 360 degrees; the windows' norms follow from them.
  double bytes_per_place() const override {
    size_t features = 0;
    for (const Place& place : places_) {
      features += size_t(std::count_if(place.features.begin(), place.features.end(),
                                       [&](const Feature& feature) { return feature.column < layout_.width_px; }));
    }
    return places_.empty() ? 0 : double(features * sizeof(Feature)) / double(places_.size());
  }

 private:
  struct Place {
    std::vector<Feature> features;  // from left to right
    std::vector<float> norms;       // of each window
  };

  cv::Mat Detect(const cv::Mat& image, std::vector<cv::KeyPoint>& points) const {
    const int wanted = int(std::lround(double(kFeaturesPerPanorama) * image.cols / layout_.width_px));
    const auto orb = cv::ORB::create(std::max(wanted, 10), 1.2f, 4, 16, 0, 2, cv::ORB::HARRIS_SCORE, 31, 8);
    cv::Mat descriptors;
    orb->detectAndCompute(image, cv::noArray(), points, descriptors);
    return descriptors;
  }

  std::vector<Feature> Features(const cv::Mat& image) const {
    std::vector<cv::KeyPoint> points;
    const cv::Mat descriptors = Detect(image, points);
    if (descriptors.empty()) return {};
    const std::vector<int> words = NearestWords(descriptors, words_);
    std::vector<Feature> features;
    for (size_t k = 0; k < points.size(); ++k) features.push_back({uint16_t(words[k]), uint16_t(points[k].pt.x)});
    return features;
  }

  void Train(const std::vector<cv::Mat>& images, uint64_t seed) {
    cv::Mat all;
    for (const cv::Mat& image : images) {
      std::vector<cv::KeyPoint> points;
      const cv::Mat descriptors = Detect(image, points);
      if (!descriptors.empty()) all.push_back(descriptors);
      if (all.rows >= kMaxTrainingDescriptors) break;
    }
    words_ = LearnWords(all, kWords, seed);
    std::vector<WordSet> documents;
    for (const cv::Mat& image : images) {
      for (int left = 0; left < image.cols; left += view_width_px_) {
        std::vector<cv::KeyPoint> points;
        const cv::Mat section = image.colRange(left, std::min(image.cols, left + view_width_px_));
        documents.push_back(WordsIn(Detect(section, points), words_));
      }
    }
    idf_ = InverseDocumentFrequency(documents, kWords);
  }

  PlaceMatch BestWindow(const Place& place, const std::vector<double>& vector, double norm) const {
    // The scalar product is a sum over the window's features: the sum up to its end less the sum up to its beginning.
    std::vector<double> sums(size_t(layout_.width_px + view_width_px_) + 1, 0.0);
    for (const Feature& feature : place.features)
      sums[std::min(size_t(feature.column) + 1, sums.size() - 1)] += vector[feature.word] * idf_[feature.word];
    for (size_t k = 1; k < sums.size(); ++k) sums[k] += sums[k - 1];
    double best = -1;
    int best_left = 0;
    for (int left = 0; left < layout_.width_px; left += kWordWindowStep_px) {
      const double product = sums[size_t(left + view_width_px_)] - sums[size_t(left)];
      const double cosine = product / (norm * std::max(place.norms[size_t(left / kWordWindowStep_px)], 1e-12f));
      if (cosine > best) best = cosine, best_left = left;
    }
    return {best, internal::BearingOf(layout_, best_left, view_width_px_)};
  }

  PanoramaLayout layout_;
  int view_width_px_;
  cv::Mat words_;
  std::vector<double> idf_;
  std::vector<Place> places_;
};

}  // namespace

std::unique_ptr<PlaceIndex> MakeOrbWordsIndex(const PlaceIndexSetup& setup) {
  return std::make_unique<OrbWordsIndex>(setup);
}

}  // namespace gaitcam
