/// MoBIF features, both approaches of the thesis combined: the image is restored where its blur is known with
/// confidence, its scale space is adapted where it is not, and a sharp image is left unchanged.

#pragma once

#include <array>
#include <string>

#include "algorithms/core/fields.h"
#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/hessian_detector.h"
#include "algorithms/features/scale_space.h"
#include "algorithms/features/sift_descriptor.h"
#include "algorithms/features/wiener.h"

namespace gaitcam {

/// What a blur averaged: light, or the grey values that a response curve made of it (light_response.h).
enum class BlurDomain { kAuto, kLinear, kDisplay };
constexpr auto WordsOf(BlurDomain) {
  return std::array{EnumWord{BlurDomain::kAuto, "auto"}, EnumWord{BlurDomain::kLinear, "linear"},
                    EnumWord{BlurDomain::kDisplay, "display"}};
}

struct MobifOptions {
  using DescribedTag = void;
  std::string psf = "spectral";  ///< Estimator by name: see psf.h.
  double min_extent_px = 6;      ///< A shorter blur is left alone.
  /// Of the estimate, from which the image is restored; below, a blurred image's scale space is adapted.
  double restore_confidence = 0.6;
  /// Blur along bent and uneven paths too (psf_path.h), where a line does not explain the image: a second or two more.
  bool paths = false;
  /// Of a path, from which the image is restored along it. Higher than restore_confidence: a sharp image that is
  /// restored by mistake loses nearly all of its features.
  double path_confidence = 0.8;
  bool regions = false;  ///< Blur that varies over the image (blur_field.h) instead of one for all of it.
  BlurDomain light = BlurDomain::kAuto;  ///< `auto`: judged by the image.
  WienerOptions wiener;
  ScaleSpaceOptions scale_space;
  /// Begin at twice the resolution where the image is sharp. Localises points of two sharp images better (0.10 instead
  /// of 0.14 px on a walk) for twice the time, but crowds out the coarser points that a blurred image still has.
  bool double_sharp = false;
  HessianOptions hessian;
  /// At most so many points per million pixels; the strongest are kept. hessian.max_points holds as well. Of a sharp
  /// image, whose fine textures have more of them, so many.
  double points_per_megapixel = 14000;
  double sharp_points_per_megapixel = 14000;
  SiftOptions sift;
  /// As the second approach does (thesis, section 5.3.2). Here it costs a fifth of the correct matches and gains no
  /// precision.
  bool discard_low_entropy = false;

  MobifOptions();
};

template <class Visitor>
void VisitFields(Visitor& visit, MobifOptions& o) {
  visit("psf", o.psf, AnyText(), "estimator of the point spread function");
  visit("min_extent_px", o.min_extent_px, AtLeast(0), "a shorter blur is left alone");
  visit("restore_confidence", o.restore_confidence, Between(0, 1), "from which the image is restored");
  visit("paths", o.paths, Nested(), "blur along bent and uneven paths too");
  visit("path_confidence", o.path_confidence, Between(0, 1), "from which the image is restored along a path");
  visit("regions", o.regions, Nested(), "blur that varies over the image");
  visit("light", o.light, EnumWords<BlurDomain>(),
        "what the blur averaged: light, grey values, or judged by the image");
  visit("wiener", o.wiener, Nested(), "restoration");
  visit("scale_space", o.scale_space, Nested(), "scales");
  visit("double_sharp", o.double_sharp, Nested(), "begin at twice the resolution where the image is sharp");
  visit("hessian", o.hessian, Nested(), "interest points");
  visit("points_per_megapixel", o.points_per_megapixel, AtLeast(100), "at most; the strongest are kept");
  visit("sharp_points_per_megapixel", o.sharp_points_per_megapixel, AtLeast(100), "the same of a sharp image");
  visit("sift", o.sift, Nested(), "descriptors");
  visit("discard_low_entropy", o.discard_low_entropy, Nested(), "discard features of low entropy");
}

/// Options without saddle points of the Hessian's determinant: fewer points, whose positions odometries can use
/// better where images are strongly blurred (results/studies/saddle_points).
MobifOptions MobifBlobsOptions();
/// Options that cost about half as much: fewer points of a blurred image.
MobifOptions MobifFastOptions();
/// Options that also look for blur along a path.
MobifOptions MobifPathOptions();

/// @throws BadOption, BadInput on an unknown estimator.
cv::Ptr<BlurAwareFeature> MakeMobif(const MobifOptions& options = {});

}  // namespace gaitcam
