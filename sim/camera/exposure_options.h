/// Exposure: one struct drives blur, brightness and noise together.

#pragma once

#include <array>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// `auto` keeps the brightness at any exposure, and amplifies the noise; `fixed` lets the brightness vary.
enum class GainMode { kAuto, kFixed };
constexpr auto WordsOf(GainMode) {
  return std::array{EnumWord{GainMode::kAuto, "auto"}, EnumWord{GainMode::kFixed, "fixed"}};
}

/// From light to the image's codes.
enum class ResponseCurve { kSrgb, kLinear };
constexpr auto WordsOf(ResponseCurve) {
  return std::array{EnumWord{ResponseCurve::kSrgb, "srgb"}, EnumWord{ResponseCurve::kLinear, "linear"}};
}

/// How the light between two renders is found; `sheared`: along the known motion of what is seen (key_picture.h);
/// `plain`: every sub-frame is rendered.
enum class LightIntegration { kSheared, kPlain };
constexpr auto WordsOf(LightIntegration) {
  return std::array{EnumWord{LightIntegration::kSheared, "sheared"}, EnumWord{LightIntegration::kPlain, "plain"}};
}

struct ExposureOptions {
  using DescribedTag = void;

  double exposure_ms = 20.0;
  double readout_ms = 0.0;
  double max_step_px = 0.5;
  int min_subframes = 1;
  int max_subframes = 128;
  int fixed_subframes = 0;
  LightIntegration integration = LightIntegration::kSheared;
  double full_well_e = 10000.0;
  double read_noise_e = 8.0;
  double noise = 1.0;
  double reference_exposure_ms = 20.0;
  GainMode gain =
      GainMode::kAuto;  ///< "auto" keeps brightness at any exposure (and amplifies noise); "fixed" lets it vary.
  ResponseCurve response = ResponseCurve::kSrgb;
};

template <class Visitor>
void VisitFields(Visitor& visit, ExposureOptions& o) {
  visit("exposure_ms", o.exposure_ms, Between(0.0, 200.0),
        "shutter open to close; 0 is one instant. The frame's stamp is the middle of it");
  visit("readout_ms", o.readout_ms, Between(0.0, 200.0), "first to last row (rolling shutter); 0 is a global shutter");
  visit("max_step_px", o.max_step_px, Between(0.05, 20.0),
        "no image point moves further than this between two sub-frames");
  visit("min_subframes", o.min_subframes, Between(1, 4096), "lower bound on the number of sub-frames");
  visit("max_subframes", o.max_subframes, Between(1, 4096), "upper bound on the number of sub-frames");
  visit("fixed_subframes", o.fixed_subframes, Between(0, 4096),
        "exactly so many, all rendered, whatever moves; 0 chooses by motion");
  visit("integration", o.integration, EnumWords<LightIntegration>(),
        "sheared computes most sub-frames from a few finer renders along the known motion; plain renders each");
  visit("full_well_e", o.full_well_e, Between(100, 1e7), "electrons at white; sets the photon shot noise");
  visit("read_noise_e", o.read_noise_e, Between(0, 1000), "standard deviation, electrons");
  visit("noise", o.noise, Between(0.0, 10.0), "factor on shot and read noise; 0 is none");
  visit("reference_exposure_ms", o.reference_exposure_ms, Between(0.1, 200.0),
        "at this exposure and gain 1 a display-white surface is just white");
  visit("gain", o.gain, EnumWords<GainMode>(),
        "auto keeps the brightness at any exposure and amplifies noise; fixed lets the brightness vary");
  visit("response", o.response, EnumWords<ResponseCurve>(), "camera response curve");
}

}  // namespace gaitcam
