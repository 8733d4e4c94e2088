/// MoBIF features, first approach (thesis, section 5.2): one blur for the whole image, restored with the Wiener filter
/// where it is long enough; interest points and descriptors of the restored image.

#pragma once

#include <memory>

#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/hessian_detector.h"
#include "algorithms/features/psf.h"
#include "algorithms/features/scale_space.h"
#include "algorithms/features/sift_descriptor.h"
#include "algorithms/features/wiener.h"

namespace gaitcam {

struct MobifRestoreOptions {
  using DescribedTag = void;
  std::string psf = "whitening";  ///< Estimator by name: see psf.h.
  double min_extent_px = 6;       ///< A shorter blur is left alone (5.2.2: "we use 6").
  WienerOptions wiener;
  ScaleSpaceOptions scale_space;
  HessianOptions hessian;
  SiftOptions sift;

  MobifRestoreOptions() { hessian.threshold = 1e-4; }  // the thesis names none
};

template <class Visitor>
void VisitFields(Visitor& visit, MobifRestoreOptions& o) {
  visit("psf", o.psf, AnyText(), "estimator of the point spread function");
  visit("min_extent_px", o.min_extent_px, AtLeast(0), "a shorter blur is left alone");
  visit("wiener", o.wiener, Nested(), "restoration");
  visit("scale_space", o.scale_space, Nested(), "scales");
  visit("hessian", o.hessian, Nested(), "interest points");
  visit("sift", o.sift, Nested(), "descriptors");
}

/// Knows one blur only: of several regions that are set, the first one's.
/// @throws BadOption, BadInput on an unknown estimator.
cv::Ptr<BlurAwareFeature> MakeMobifRestore(const MobifRestoreOptions& options = {});

}  // namespace gaitcam
