/// Orientation and SIFT descriptor of an interest point, with the windows of the thesis (section 5.2.4, equation 5.10).

#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/features.h"
#include "algorithms/features/hessian_detector.h"
#include "algorithms/features/scale_space.h"

namespace gaitcam {

constexpr int kSiftLength = 128;  ///< 4 x 4 cells of 8 directions.

struct SiftOptions {
  using DescribedTag = void;
  double orientation_window = 12;  ///< Side of the window for the orientation, in units of the point's scale.
  double orientation_sigma = 2.5;  ///< Its Gaussian weight, likewise.
  double orientation_peak = 0.8;   ///< Directions that reach this part of the strongest make a point each.
  double descriptor_window = 20;   ///< Side of the descriptor's window, in units of the point's scale.
  double descriptor_sigma = 6.7;   ///< Its Gaussian weight, likewise.
  double clip = 0.2;               ///< Entries of the unit vector are cut here, then normalised again (Lowe 2004).
  /// Length of three further entries that tell dark blobs, bright blobs and saddles apart; 0: no further entries. Half
  /// the squared distance of two kinds is this squared.
  double kind_weight = 0;
  bool root = false;  ///< Square root of the entries that sum to 1 (RootSIFT, Arandjelovic 2012).
};

template <class Visitor>
void VisitFields(Visitor& visit, SiftOptions& o) {
  visit("orientation_window", o.orientation_window, Between(2, 40), "side, in units of the point's scale");
  visit("orientation_sigma", o.orientation_sigma, Between(0.5, 20), "Gaussian weight, likewise");
  visit("orientation_peak", o.orientation_peak, Between(0.1, 1), "part of the strongest direction that makes a point");
  visit("descriptor_window", o.descriptor_window, Between(4, 60), "side, in units of the point's scale");
  visit("descriptor_sigma", o.descriptor_sigma, Between(1, 40), "Gaussian weight, likewise");
  visit("clip", o.clip, Between(0.05, 1), "entries of the unit vector are cut here");
  visit("kind_weight", o.kind_weight, Between(0, 2), "length of the entries that tell kinds of points apart");
  visit("root", o.root, Nested(), "RootSIFT");
}

/// Entries of a descriptor made with these options.
int SiftLength(const SiftOptions& options);

/// First derivatives of one level as equation 5.9 has them, L(x + 1) - L(x - 1): CV_32FC2, (Lx, Ly); 0 at the border.
cv::Mat Gradients(const cv::Mat& light);

/// Describes points; one with several orientations becomes several features. Keypoints are in pixels of the image:
/// `size` is twice the scale (a radius would be the scale), `angle` in degrees as OpenCV has it (clockwise on the
/// screen), `octave` the index in the scale space. Descriptors have length 1.
/// @param points as DetectHessian orders them.
/// @param most kAllFeatures, or else points are described in the order of their responses, the largest first, until no
/// further one can be among the `most` features of largest response.
Features DescribeSift(const ScaleSpace& space, const std::vector<ScalePoint>& points, const SiftOptions& options,
                      int most = kAllFeatures);

}  // namespace gaitcam
