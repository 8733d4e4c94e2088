/// Which known place does a view show? One interface for the wavelet signature and the methods it is compared with.

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/places/panorama.h"
#include "algorithms/places/wavelet_map.h"
#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

/// How well a view fits one known place.
struct PlaceMatch {
  double similarity = 0;   ///< Greater is better, >= 0; its scale is the method's own.
  double bearing_rad = 0;  ///< Of the view's middle in the panorama: 0 is the panorama's middle, left is positive.
};

/// Known places, each represented by what a method keeps of its panorama.
class PlaceIndex {
 public:
  virtual ~PlaceIndex() = default;
  /// @param panorama CV_8UC1 of the index's layout. @throws BadInput if it is not.
  virtual void Add(const cv::Mat& panorama) = 0;
  /// @param view CV_8UC1, a section of the layout's cylinder (CylinderProjection::ProjectView) of the index's view
  /// width.
  /// @returns one match for each place in the order of Add(). @throws BadInput if there is none, or for another size.
  virtual std::vector<PlaceMatch> Query(const cv::Mat& view) const = 0;
  virtual size_t size() const = 0;
  /// Memory of one place, on average.
  virtual double bytes_per_place() const = 0;
};

struct PlaceIndexSetup {
  PanoramaLayout layout;
  int view_width_px = 0;          ///< CylinderProjection::width_px().
  std::vector<cv::Mat> training;  ///< CV_8UC1, for methods that are trained: orb_words.
  uint64_t seed = 1;              ///< Of their random numbers.
  WaveletOptions wavelet;
};

/// "wavelet": the thesis's. "fourier": spectra of all windows of a view's width; "fourier_whole": one spectrum of the
/// whole panorama (the thesis's reference [64]). "thumbnail": the image itself, reduced. "orb_words": a bag of words of
/// ORB features in windows of a view's width.
std::vector<std::string> PlaceIndexNames();

/// @throws BadInput naming the unknown method and the nearest known one, a panorama narrower than the view, or images
/// that a method cannot work on.
std::unique_ptr<PlaceIndex> MakePlaceIndex(const std::string& name, const PlaceIndexSetup& setup);

namespace internal {
/// @throws BadInput unless `image` is CV_8UC1 of this size; `what` is named.
void CheckPlaceImage(const cv::Mat& image, int width_px, int height_px, const char* what);
/// Heading of the middle of a view whose left edge lies in this column of the panorama, in [-pi, pi).
double BearingOf(const PanoramaLayout& layout, double left_px, int view_width_px);
}  // namespace internal

}  // namespace gaitcam
