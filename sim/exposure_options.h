/// The shutter and what it lets onto the sensor. One struct drives blur, brightness and noise together.

#pragma once

#include <string>

#include "algorithms/core/fields.h"

namespace gaitcam {

struct ExposureOptions {
  using DescribedTag = void;

  double exposure_ms = 20.0;  ///< Shutter open to close; 0 is one instant. The frame's stamp is the middle of it.
  double readout_ms = 0.0;    ///< First to last row (rolling shutter); 0 means global shutter.
  double max_step_px = 0.5;   ///< No image point moves further than this between two sub-frames.
  int min_subframes = 1;
  int max_subframes = 128;
  int fixed_subframes = 0;              ///< If positive: exactly so many, whatever moves.
  double full_well_e = 10000.0;         ///< Electrons at white: sets the photon shot noise.
  double read_noise_e = 8.0;            ///< Standard deviation, electrons.
  double noise = 1.0;                   ///< Factor on both; 0 switches noise off.
  double reference_exposure_ms = 20.0;  ///< At this exposure and gain 1 a display-white surface is just white.
  std::string gain = "auto";  ///< "auto" keeps brightness at any exposure (and amplifies noise); "fixed" lets it vary.
  std::string response = "srgb";  ///< Camera response curve: "srgb" or "linear".
};

template <class Visitor>
void VisitFields(Visitor& visit, ExposureOptions& o) {
  visit("exposure_ms", o.exposure_ms, Between(0.0, 200.0), "shutter open to close");
  visit("readout_ms", o.readout_ms, Between(0.0, 200.0), "first to last row; 0 is a global shutter");
  visit("max_step_px", o.max_step_px, Between(0.05, 20.0), "largest motion between two sub-frames");
  visit("min_subframes", o.min_subframes, Between(1, 4096), "bound on the number of sub-frames");
  visit("max_subframes", o.max_subframes, Between(1, 4096), "bound on the number of sub-frames");
  visit("fixed_subframes", o.fixed_subframes, Between(0, 4096), "exactly so many; 0 chooses by motion");
  visit("full_well_e", o.full_well_e, Between(100, 1e7), "electrons at white");
  visit("read_noise_e", o.read_noise_e, Between(0, 1000), "electrons, standard deviation");
  visit("noise", o.noise, Between(0.0, 10.0), "factor on shot and read noise; 0 is none");
  visit("reference_exposure_ms", o.reference_exposure_ms, Between(0.1, 200.0), "exposure at which gain is 1");
  visit("gain", o.gain, OneOf({"auto", "fixed"}), "auto keeps the brightness at any exposure");
  visit("response", o.response, OneOf({"srgb", "linear"}), "camera response curve");
}

}  // namespace gaitcam
