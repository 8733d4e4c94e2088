#include "algorithms/places/thumbnail.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/places/place_recognition.h"

namespace gaitcam {
namespace {

constexpr int kCell_px = 8;

class ThumbnailIndex : public PlaceIndex {
 public:
  explicit ThumbnailIndex(const PlaceIndexSetup& setup)
      : layout_(setup.layout),
        view_width_px_(setup.view_width_px),
        columns_(setup.layout.width_px / kCell_px),
        view_columns_(setup.view_width_px / kCell_px),
        rows_(setup.layout.height_px / kCell_px) {
    if (rows_ < 1 || view_columns_ < 1) {
      throw BadInput("places: a view of " + std::to_string(setup.view_width_px) + " x " +
                     std::to_string(setup.layout.height_px) + " px is smaller than a thumbnail's cell of 8 x 8 px");
    }
  }

  void Add(const cv::Mat& panorama) override {
    internal::CheckPlaceImage(panorama, layout_.width_px, layout_.height_px, "panorama");
    places_.push_back(Shrunk(panorama, columns_));
  }

  std::vector<PlaceMatch> Query(const cv::Mat& view) const override {
    internal::CheckPlaceImage(view, view_width_px_, layout_.height_px, "view");
    if (places_.empty()) throw BadInput("places: the index is empty, there is nothing to compare a view with");
    // Whole cells only: the rest at the view's right is left out.
    const cv::Mat small = Shrunk(view.colRange(0, view_columns_ * kCell_px), view_columns_);
    const double cell_px = double(layout_.width_px) / columns_;
    std::vector<PlaceMatch> matches;
    for (const cv::Mat& place : places_) {
      cv::Mat unrolled, scores;
      cv::hconcat(place, place.colRange(0, view_columns_ - 1), unrolled);
      cv::matchTemplate(unrolled, small, scores, cv::TM_CCOEFF_NORMED);
      double best = 0;
      cv::Point at;
      cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
      matches.push_back({0.5 * (1 + best), internal::BearingOf(layout_, at.x * cell_px, view.cols)});
    }
    return matches;
  }

  size_t size() const override { return places_.size(); }
  double bytes_per_place() const override { return double(columns_) * rows_; }

 private:
  cv::Mat Shrunk(const cv::Mat& image, int columns) const {
    cv::Mat small;
    cv::resize(image, small, {columns, rows_}, 0, 0, cv::INTER_AREA);
    return small;
  }

  PanoramaLayout layout_;
  int view_width_px_, columns_, view_columns_, rows_;
  std::vector<cv::Mat> places_;
};

}  // namespace

std::unique_ptr<PlaceIndex> MakeThumbnailIndex(const PlaceIndexSetup& setup) {
  return std::make_unique<ThumbnailIndex>(setup);
}

}  // namespace gaitcam
