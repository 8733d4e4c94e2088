#include "scenarios/code/files/calibration_error_options.h"

#include "models/code/yaml/preset_block.h"

namespace gaitcam {

CalibrationErrorOptions CalibrationErrorOptions::Of(Preset preset) {
  CalibrationErrorOptions o;
  o.preset = preset;
  if (preset == Preset::kNone) return o;
  o.focal_pct = 0.3;
  o.centre_px = 1;
  o.imu_deg = 0.5;
  o.time_offset_ms = 2;
  o.height_pct = 2;
  o.pitch_deg = 0.5;
  o.encoder_deg = 0.3;
  o.stereo_deg = 0.05;
  o.right_focal_pct = 0.05;
  o.right_centre_px = 0.2;
  return o;
}

void ReadOption(const OptionValue& node, CalibrationErrorOptions& value) { ReadPresetBlock(node, value); }

bool SaysNothing(const CalibrationErrorOptions& value) { return IsPlainBlock(value); }

}  // namespace gaitcam
