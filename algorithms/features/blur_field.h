/// Blur that varies over the image as it does for a camera that turns: three numbers for the whole field.
///
/// A small turn by (t_x, t_y, t_z) about the camera's axes moves the point at normalised coordinates (x, y) by
///   du = b_x + x (x b_x + y b_y) + f t_z y,    dv = b_y + y (x b_x + y b_y) - f t_z x,
/// where (b_x, b_y) = f (-t_y, t_x) is the motion at the image's centre (Longuet-Higgins and Prazdny 1980, the terms of
/// rotation). Spectra of overlapping tiles say which lines fit each tile; the three numbers that fit all tiles at once
/// are the field. So a tile of little texture does no harm, and no tile is decided alone.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

struct BlurFieldOptions {
  using DescribedTag = void;
  int tile_px = 128;             ///< Side of the tiles, a power of two.
  double focal_px = 0;           ///< f; 0: unknown, the field is then taken to be affine (f infinite).
  double max_extent_px = 50;     ///< Longest blur considered, at the centre and from the roll at the corners.
  double verdict_px = 6;         ///< Shorter blurs are left alone.
  double min_confidence = 0.6;   ///< For the verdict "blurred".
  double tolerance_px = 2;       ///< Regions are divided until the blur in them varies by less than this,
  double tolerance_share = 0.1;  ///< or by this part of its extent,
  int min_region_px = 60;        ///< or would be smaller than this.

  /// @throws BadOption naming field, value and what is permitted.
  void Check() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, BlurFieldOptions& o) {
  visit("tile_px", o.tile_px, Between(64, 256), "side of the tiles, a power of two");
  visit("focal_px", o.focal_px, Between(0, 1e6), "focal length; 0 is unknown");
  visit("max_extent_px", o.max_extent_px, Between(8, 60), "longest blur considered");
  visit("verdict_px", o.verdict_px, Between(0, 60), "shorter blurs are left alone");
  visit("min_confidence", o.min_confidence, Between(0, 1), "for the verdict blurred");
  visit("tolerance_px", o.tolerance_px, Between(0.1, 100), "how much the blur may vary in a region");
  visit("tolerance_share", o.tolerance_share, Between(0, 1), "the same in parts of its extent");
  visit("min_region_px", o.min_region_px, Between(8, 1000), "regions are not divided below this");
}

struct BlurField {
  Eigen::Vector2d at_centre = Eigen::Vector2d::Zero();  ///< (b_x, b_y), px. The sign of the whole field is arbitrary.
  double roll_rad = 0;                                  ///< t_z: turn about the optical axis.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     ///< Of the image, px.
  double focal_px = 0;                                  ///< 0: infinite.
  double confidence = 0;  ///< Correlation of the ripple that all tiles share with a line's.

  Eigen::Vector2d VectorAt(const Eigen::Vector2d& pixel) const;
  LineBlur At(const Eigen::Vector2d& pixel) const { return LineBlur::FromVector(VectorAt(pixel)); }
};

/// @param grey CV_8UC1. An image smaller than a tile, or without texture, gives confidence 0.
/// @throws BadOption
BlurField EstimateBlurField(const cv::Mat& grey, const BlurFieldOptions& options = {});

/// Cuts an image in halves until the blur of each part hardly varies. Every part carries the blur of its middle.
/// @returns regions that cover the image without overlap.
std::vector<BlurRegion> DivideByBlur(const BlurField& field, const cv::Size& image,
                                     const BlurFieldOptions& options = {});

/// Both in one.
std::vector<BlurRegion> SegmentBlurField(const cv::Mat& grey, const BlurFieldOptions& options = {});

}  // namespace gaitcam
