/// Image regions that may show a plane, proposed without knowledge of the scene (thesis 6.3).
///
/// A floor of one colour has gradients at its boundary only: a region that edges enclose is proposed by the band along
/// its boundary. Planks, tiles and carpets are textured and have no closed outline: there, blocks of dense texture are
/// proposed. Which of them lie in the floor is decided by alignment (floor_regions.h, thesis 6.4.2).

#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"

namespace gaitcam {

/// By what regions are proposed: their outline, their texture, or both.
enum class RegionSelector { kBoundary, kTexture, kBoth };
constexpr auto WordsOf(RegionSelector) {
  return std::array{EnumWord{RegionSelector::kBoundary, "boundary"}, EnumWord{RegionSelector::kTexture, "texture"},
                    EnumWord{RegionSelector::kBoth, "both"}};
}

struct PutativePlaneOptions {
  using DescribedTag = void;
  RegionSelector selector = RegionSelector::kBoth;
  int max_regions = 24;  ///< The largest of each selector are kept.

  double canny_low = 30, canny_high = 80;  ///< Gradients as the Sobel operator has them: 4 per grey level per pixel
                                           ///< of a ramp.
  int closing_px = 2;                      ///< Radius of the dilation and erosion that close gaps in edges.
  double min_area_ratio = 0.01;            ///< Area of a region that edges enclose, part of the image.
  int band_px = 6;                         ///< Thickness of a boundary (thesis 6.3).

  double texture_gradient_grey = 2.5;  ///< Per pixel, after smoothing with 1 px; less is noise.
  int texture_window_px = 21;          ///< Side of the square within which texture is counted.
  double texture_density = 0.33;       ///< Textured part of that square, at least.
  double min_texture_ratio = 0.006;    ///< Area of a textured region, part of the image.
  int block_px = 64;                   ///< Textured regions are cut along a grid of this width; 0: not cut.
};

template <class Visitor>
void VisitFields(Visitor& visit, PutativePlaneOptions& o) {
  visit("selector", o.selector, EnumWords<RegionSelector>(), "regions by their outline, by their texture");
  visit("max_regions", o.max_regions, Between(1, 1000), "largest regions kept, of each selector");
  visit("canny_low", o.canny_low, Between(1, 2000), "edges end below this Sobel gradient");
  visit("canny_high", o.canny_high, Between(1, 2000), "edges start above this Sobel gradient");
  visit("closing_px", o.closing_px, Between(0, 20), "radius by which gaps in edges are closed");
  visit("min_area_ratio", o.min_area_ratio, Between(0.0001, 1.0), "least part of the image that edges enclose");
  visit("band_px", o.band_px, Between(2, 64), "thickness of a boundary");
  visit("texture_gradient_grey", o.texture_gradient_grey, Between(0.1, 255.0), "grey per pixel; less is noise");
  visit("texture_window_px", o.texture_window_px, Between(3, 255), "side of the square for the density of texture");
  visit("texture_density", o.texture_density, Between(0.01, 1.0), "part of the square that is textured");
  visit("min_texture_ratio", o.min_texture_ratio, Between(0.0001, 1.0), "least part of the image with texture");
  visit("block_px", o.block_px, Between(0, 10000), "grid that cuts textured regions; 0: whole");
}

/// A region. Its masks (CV_8UC1, 255 or 0) cover the rectangle `at` of the image.
struct PutativePlane {
  enum class Kind { kBoundary, kTexture };
  Kind kind = Kind::kBoundary;
  cv::Rect at;
  cv::Mat pixels;    ///< What to align: the boundary's band, or the textured region.
  cv::Mat enclosed;  ///< The region with its inside (holes filled).
  int area_px = 0;   ///< Of `enclosed`.
};

/// @param image undistorted, CV_8UC1 or CV_8UC3.
/// @return largest first; of equal ones, boundaries first and then the upper, left one. The image's border is no
/// boundary; a region without any other is left out.
/// @throws BadOption; BadInput if the image is of another type or a side is below 32 px.
std::vector<PutativePlane> FindPutativePlanes(const cv::Mat& image, const PutativePlaneOptions& options = {});

/// The union of the regions' `pixels`, or of their `enclosed`: CV_8UC1 of the image's size.
cv::Mat UnionOfPixels(const std::vector<PutativePlane>& planes, cv::Size image_size);
cv::Mat UnionOfEnclosed(const std::vector<PutativePlane>& planes, cv::Size image_size);

}  // namespace gaitcam
