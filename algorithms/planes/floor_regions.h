/// Which image regions lie on the floor (thesis 6.4.2): each putative plane is aligned on its own, once the camera has
/// moved enough for parallax against the floor to show.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/planes/plane_alignment.h"
#include "algorithms/planes/putative_planes.h"

namespace gaitcam {

struct FloorRegionOptions {
  using DescribedTag = void;
  PutativePlaneOptions putative;
  double max_shift_px = 1.5;     ///< Between a floor region's motion under its own plane and under the floor's.
  double max_tilt_deg = 25;      ///< Between its normal and the floor's, beyond 3 standard deviations.
  double min_correlation = 0.5;  ///< Of the two images under its own plane.
  int min_points = 40;           ///< Textured pixels; with fewer, a region is not judged and counts as floor.
};

template <class Visitor>
void VisitFields(Visitor& visit, FloorRegionOptions& o) {
  visit("putative", o.putative, Nested(), "what is judged");
  visit("max_shift_px", o.max_shift_px, Between(0.05, 100.0), "larger shift against the floor: rejected");
  visit("max_tilt_deg", o.max_tilt_deg, Between(0.1, 90.0), "leaning more, where it can be told: rejected");
  visit("min_correlation", o.min_correlation, Between(-1.0, 1.0), "explained worse by any plane: rejected");
  visit("min_points", o.min_points, Between(30, 100000), "fewer textured pixels: not judged");
}

struct FloorRegion {
  PutativePlane plane;
  bool judged = false;
  bool is_floor = true;
  double shift_px = 0;         ///< Mean over its pixels, as max_shift_px.
  double tilt_deg = 0;         ///< Between its normal and the floor's ...
  double tilt_sigma_deg = 90;  ///< ... and its standard deviation.
  double correlation = 0;      ///< Of the two images under its own plane.
};

/// @param planes of the reference image. @param floor the motion and the floor's plane, from all regions together.
std::vector<FloorRegion> JudgeRegions(const PlaneAligner& aligner, const CameraModel& camera,
                                      const PlaneReference& reference, const std::vector<PutativePlane>& planes,
                                      const ImagePyramid& current, const PlaneState& floor, const CurrentBlur& blur,
                                      const FloorRegionOptions& options);

}  // namespace gaitcam
