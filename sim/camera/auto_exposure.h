/// Exposure time and gain that follow the light, frame by frame, as a camera's own control sets them.
///
/// A frame's mean light, linear, 1 being white, is m = s L g t / t_ref: scene's light level s, mean luminance L of what
/// is seen, gain g, exposure t. Each frame's meter reading moves the next frame's g t towards the target m* by
///   log(g t) += speed * log(m* / m).
/// Time is spent first, then gain. It starts from `exposure_ms` and a gain of 1 and depends on the frames before alone.

#pragma once

#include "algorithms/core/fields.h"

namespace gaitcam {

struct AutoExposureOptions {
  using DescribedTag = void;
  bool enabled = true;
  double target = 0.18;
  double speed = 0.5;
  double min_ms = 0.5;
  double max_ms = 30;
  double max_gain = 16;

  /// @throws BadOption.
  void Check() const;
};

template <class Visitor>
void VisitFields(Visitor& visit, AutoExposureOptions& o) {
  visit("enabled", o.enabled, Nested(),
        "exposure and gain follow the light; `exposure_ms` is where they start, `gain` unused");
  visit("target", o.target, Between(0.01, 0.9), "mean light of an image that is aimed at, linear, 1 is white");
  visit("speed", o.speed, Between(0.01, 1), "part of the error, as a logarithm, that one frame takes away");
  visit("min_ms", o.min_ms, Between(0.01, 200), "shortest exposure");
  visit("max_ms", o.max_ms, Between(0.01, 200), "longest exposure");
  visit("max_gain", o.max_gain, Between(1, 1000), "beyond it images stay dark");
}

class AutoExposure {
 public:
  /// @param first_ms exposure of the first frame. @param reference_ms where light 1 is just white at gain 1.
  AutoExposure(const AutoExposureOptions& options, double first_ms, double reference_ms);

  /// Of the next frame.
  double exposure_ms() const;
  double gain() const;
  /// @param luminance mean light that reached the sensor, at the reference exposure and gain 1, >= 0.
  void Measure(double luminance);

 private:
  AutoExposureOptions options_;
  double reference_ms_, product_ms_;  ///< Gain times exposure.
};

}  // namespace gaitcam
