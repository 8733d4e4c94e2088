/// Point spread function by an approximated whitening method (thesis, section 5.2.1; after Yitzhaky and Kopeika 1997).
///
/// Motion removes detail along its direction, which is that of the smallest mean absolute derivative. Derivatives
/// along that direction of an evenly blurred image are differences of what lay one extent apart; so their
/// auto-correlation is negative there.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/psf.h"

namespace gaitcam {

struct WhiteningOptions {
  using DescribedTag = void;
  int directions = 36;           ///< Bins over 180 degrees; the thesis has one each 5 degrees.
  int sample_step_px = 5;        ///< Between the points where derivatives are taken.
  int min_extent_px = 4;         ///< Minima of the auto-correlation below this are taken for noise ("2-3 pixels").
  int max_extent_px = 60;        ///< Longest blur considered.
  double verdict_px = 6;         ///< A shorter blur is no reason to act (section 5.2.2).
  double min_confidence = 0.12;  ///< Least depth of the minimum for the verdict "blurred"; the thesis has no such test.
};

template <class Visitor>
void VisitFields(Visitor& visit, WhiteningOptions& o) {
  visit("directions", o.directions, Between(4, 360), "bins over 180 degrees");
  visit("sample_step_px", o.sample_step_px, Between(1, 50), "between the points where derivatives are taken");
  visit("min_extent_px", o.min_extent_px, Between(1, 50), "shorter minima of the auto-correlation are taken for noise");
  visit("max_extent_px", o.max_extent_px, Between(8, 500), "longest blur considered");
  visit("verdict_px", o.verdict_px, Between(0, 500), "shorter blurs are left alone");
  visit("min_confidence", o.min_confidence, Between(0, 1), "least depth of the minimum for the verdict blurred");
}

/// Confidence is the depth of the auto-correlation's minimum in parts of its value at lag 0, 0.5 being the depth that
/// an evenly blurred image of unrelated pixels has; scaled so that 1 is that. Needs 32 x 32 px.
class WhiteningPsf : public PsfEstimator {
 public:
  /// @throws BadOption
  explicit WhiteningPsf(const WhiteningOptions& options = {});
  using PsfEstimator::Estimate;
  BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const override;

  /// Extent along a known direction, from the pixels where `mask` is not 0 alone.
  /// @param mask CV_8UC1 of the image's size, or empty for all pixels.
  BlurEstimate EstimateExtent(const cv::Mat& grey, const cv::Mat& mask, double direction_rad) const;

 private:
  WhiteningOptions options_;
};

/// Sum over sample points of absolute derivatives in each of `bins` directions over 180 degrees, bin b being direction
/// pi b / bins: difference of the pixel and its bilinearly interpolated neighbour 1 px away.
/// @param grey CV_32FC1.
std::vector<double> DirectionalDerivatives(const cv::Mat& grey, const cv::Rect& region, int bins, int step_px);

/// Direction of the least of the bins that DirectionalDerivatives made, refined by a parabola through its neighbours.
double LeastDirection(const std::vector<double>& bins);

}  // namespace gaitcam
