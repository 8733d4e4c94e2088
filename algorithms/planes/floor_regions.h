/// Which parts of an image lie on the floor (thesis 6.4.2): each putative plane is aligned on its own, once the camera
/// has moved enough for what stands on the floor to shift against it.

#pragma once

#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/planes/plane_alignment.h"
#include "algorithms/planes/putative_planes.h"

namespace gaitcam {

struct FloorRegionOptions {
  using DescribedTag = void;
  PutativePlaneOptions putative;
  double max_shift_px = 1.5;     ///< A region whose own plane moves its pixels otherwise than the floor by more ...
  double max_tilt_deg = 25;      ///< ... or leans more, where it can be told, is no floor;
  double min_correlation = 0.5;  ///< ... nor is one that no plane explains.
  int min_points = 40;           ///< A region with fewer pixels of texture is not judged: it goes with the floor.
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
  double shift_px = 0;         ///< Between its own plane's and the floor's motion, mean over its pixels.
  double tilt_deg = 0;         ///< Of its normal against the floor's ...
  double tilt_sigma_deg = 90;  ///< ... and how well that is known.
  double correlation = 0;      ///< Of the two images under its own plane.
};

/// @param planes found in the reference image. @param floor the motion and the floor's plane by all of them together.
std::vector<FloorRegion> JudgeRegions(const PlaneAligner& aligner, const CameraModel& camera,
                                      const PlaneReference& reference, const std::vector<PutativePlane>& planes,
                                      const ImagePyramid& current, const PlaneState& floor, const CurrentBlur& blur,
                                      const FloorRegionOptions& options);

}  // namespace gaitcam
