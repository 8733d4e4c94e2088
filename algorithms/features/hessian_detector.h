/// Interest points where the determinant of the Hessian has a maximum over position and scale (thesis, section 5.2.3,
/// equations 5.8 and 5.9).

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/scale_space.h"

namespace gaitcam {

/// Sign of an interest point's contrast; points of different kinds never correspond.
enum class PointKind { kDark = 0, kBright = 1, kSaddle = 2 };

/// An interest point of one octave.
struct ScalePoint {
  int octave = 0, level = 0;  ///< Where its maximum lies: indices into the scale space.
  float x = 0, y = 0;         ///< In the octave's pixels, interpolated.
  float scale = 0;            ///< Characteristic scale in the octave's pixels, interpolated.
  PointKind kind = PointKind::kDark;
  float response = 0;  ///< Scale-normalised determinant of the Hessian, light from 0 to 1.
};

struct HessianOptions {
  using DescribedTag = void;
  double threshold = 6e-4;  ///< Of the scale-normalised determinant, light from 0 to 1.
  /// Second derivatives from neighbours one pixel away instead of equation 5.9's first derivatives applied twice: less
  /// smoothing, so finer points.
  bool compact = false;
  bool saddles = false;       ///< Take minima of the determinant too: corners between blobs, as on a chessboard.
  double max_anisotropy = 0;  ///< Ratio of the Hessian's eigenvalues, above which a point is an edge; 0: no limit.
  int max_points = 20000;     ///< The strongest are kept.
};

template <class Visitor>
void VisitFields(Visitor& visit, HessianOptions& o) {
  visit("threshold", o.threshold, Positive(), "of the scale-normalised determinant, light from 0 to 1");
  visit("compact", o.compact, Nested(), "second derivatives from nearest neighbours");
  visit("saddles", o.saddles, Nested(), "minima of the determinant too");
  visit("max_anisotropy", o.max_anisotropy, AtLeast(0), "ratio of the Hessian's eigenvalues; 0: no limit");
  visit("max_points", o.max_points, AtLeast(1), "the strongest are kept");
}

/// Points in the order of octave, level, row, column.
/// @param region in pixels of the image; only points in it are returned. Empty: everywhere.
std::vector<ScalePoint> DetectHessian(const ScaleSpace& space, const HessianOptions& options,
                                      const cv::Rect& region = {});

/// The scale-normalised determinant of the Hessian of one level, CV_32FC1; 0 in a border of 2 pixels.
cv::Mat HessianDeterminant(const ScaleLevel& level, bool compact);

}  // namespace gaitcam
