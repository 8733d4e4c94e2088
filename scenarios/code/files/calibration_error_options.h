/// `calibration_error:` of a scenario: what the calibration that a system is given has wrong, as one from a real bench
/// has. It changes neither the walk nor its frames, nor what is scored against.

#pragma once

#include <array>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/option_value.h"

namespace gaitcam {

enum class CalibrationErrorPreset { kNone, kBench };
constexpr auto WordsOf(CalibrationErrorPreset) {
  return std::array{EnumWord{CalibrationErrorPreset::kNone, "none"}, EnumWord{CalibrationErrorPreset::kBench, "bench"}};
}

/// Standard deviations of normal distributions, from which the seed draws once per run. The defaults change nothing.
struct CalibrationErrorOptions {
  using DescribedTag = void;
  using Preset = CalibrationErrorPreset;
  Preset preset = Preset::kNone;
  double focal_pct = 0;
  double centre_px = 0;
  double distortion_px = 0;
  double imu_deg = 0;
  double imu_scale_pct = 0;
  double time_offset_ms = 0;
  double height_pct = 0;
  double pitch_deg = 0;
  double encoder_deg = 0;
  double switch_delay_ms = 0;
  double switch_bounce_ms = 0;
  double stereo_deg = 0;
  double right_focal_pct = 0;
  double right_centre_px = 0;

  static CalibrationErrorOptions Of(Preset preset);
};

template <class Visitor>
void VisitFields(Visitor& visit, CalibrationErrorOptions& o) {
  visit(
      "preset", o.preset, EnumWords<CalibrationErrorPreset>(),
      "what the other keys, all standard deviations, start from: none; or bench: 0.3 % of focal length, 1 px, 0.5 "
      "deg of the IMU, 2 ms, 2 % of height, 0.5 deg of pitch, 0.3 deg of each encoder; of a stereo rig's right camera "
      "0.05 deg, and of its lens alone 0.05 % and 0.2 px");
  visit("focal_pct", o.focal_pct, Between(0, 20), "1 sigma; focal length, fx and fy alike");
  visit("centre_px", o.centre_px, Between(0, 100), "1 sigma; principal point, each of cx and cy");
  visit("distortion_px", o.distortion_px, Between(0, 100), "1 sigma; k1, by what it moves at the image's corners");
  visit("imu_deg", o.imu_deg, Between(0, 20), "1 sigma; direction of the IMU, about each axis of its own");
  visit("imu_scale_pct", o.imu_scale_pct, Between(0, 20),
        "1 sigma; readings of each axis of gyroscope and accelerometer");
  visit("time_offset_ms", o.time_offset_ms, Between(0, 500),
        "1 sigma; stamps of IMU, encoders, foot switches and odometry against the camera's");
  visit("height_pct", o.height_pct, Between(0, 30), "1 sigma; the standing camera's height over the floor");
  visit("pitch_deg", o.pitch_deg, Between(0, 30), "1 sigma; the standing camera's tilt");
  visit("encoder_deg", o.encoder_deg, Between(0, 20), "1 sigma; zero of each turning joint's encoder");
  visit("switch_delay_ms", o.switch_delay_ms, Between(0, 500),
        "1 sigma; each foot switch is late by the draw's absolute value");
  visit("switch_bounce_ms", o.switch_bounce_ms, Between(0, 500),
        "1 sigma; for the draw's absolute value after each change, a foot switch reads open or closed at random");
  visit("stereo_deg", o.stereo_deg, Between(0, 20),
        "1 sigma; the right camera's direction, about each axis of its own");
  visit("right_focal_pct", o.right_focal_pct, Between(0, 20),
        "1 sigma; the right focal length, beside what both are off alike");
  visit("right_centre_px", o.right_centre_px, Between(0, 100),
        "1 sigma; the right principal point, each of cx and cy, likewise");
}

void ReadOption(const OptionValue& node, CalibrationErrorOptions& value);
/// Whether nothing is wrong; a resolved scenario then has no such block.
bool SaysNothing(const CalibrationErrorOptions& value);

}  // namespace gaitcam
