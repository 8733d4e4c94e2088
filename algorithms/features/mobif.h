/// MoBIF features, as good as they can be made: the image is restored where its blur is certain, smoothed less along
/// the blur where it is not, and left alone where it is sharp.

#pragma once

#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/hessian_detector.h"
#include "algorithms/features/scale_space.h"
#include "algorithms/features/sift_descriptor.h"
#include "algorithms/features/wiener.h"

namespace gaitcam {

struct MobifOptions {
  using DescribedTag = void;
  std::string psf = "spectral";     ///< Estimator by name: see psf.h.
  double restore_confidence = 0.5;  ///< Of the estimate, from which the image is restored and not just adapted.
  WienerOptions wiener;
  ScaleSpaceOptions scale_space;
  HessianOptions hessian;
  SiftOptions sift;

  MobifOptions();
};

template <class Visitor>
void VisitFields(Visitor& visit, MobifOptions& o) {
  visit("psf", o.psf, AnyText(), "estimator of the point spread function");
  visit("restore_confidence", o.restore_confidence, Between(0, 1), "from which the image is restored");
  visit("wiener", o.wiener, Nested(), "restoration");
  visit("scale_space", o.scale_space, Nested(), "scales");
  visit("hessian", o.hessian, Nested(), "interest points");
  visit("sift", o.sift, Nested(), "descriptors");
}

/// Options that cost about half as much.
MobifOptions MobifFastOptions();

/// @throws BadOption, BadInput on an unknown estimator.
cv::Ptr<BlurAwareFeature> MakeMobif(const MobifOptions& options = {});

}  // namespace gaitcam
