/// MoBIF features, second approach (thesis, section 5.3): the image is divided into rectangles with a blur of their
/// own; each has a scale space that smooths less along its blur; features of low entropy are discarded.

#pragma once

#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/blur_segmentation.h"
#include "algorithms/features/hessian_detector.h"
#include "algorithms/features/scale_space.h"
#include "algorithms/features/sift_descriptor.h"

namespace gaitcam {

struct MobifAdaptOptions {
  using DescribedTag = void;
  BlurSegmentationOptions segmentation;
  /// Pixels of its neighbours that a rectangle's scale space sees, so that windows near its edges are whole.
  int margin_px = 64;
  bool discard_low_entropy = true;  ///< 5.3.2.
  ScaleSpaceOptions scale_space;
  HessianOptions hessian;
  SiftOptions sift;

  MobifAdaptOptions() { hessian.threshold = 1e-4; }  // the thesis names none
};

template <class Visitor>
void VisitFields(Visitor& visit, MobifAdaptOptions& o) {
  visit("segmentation", o.segmentation, Nested(), "division into rectangles");
  visit("margin_px", o.margin_px, Between(0, 1000), "pixels of its neighbours that a rectangle sees");
  visit("discard_low_entropy", o.discard_low_entropy, Nested(), "discard features of low entropy");
  visit("scale_space", o.scale_space, Nested(), "scales");
  visit("hessian", o.hessian, Nested(), "interest points");
  visit("sift", o.sift, Nested(), "descriptors");
}

/// @throws BadOption.
cv::Ptr<BlurAwareFeature> MakeMobifAdapt(const MobifAdaptOptions& options = {});

}  // namespace gaitcam
