/// Calibrations on disk: our own calibration.yaml, the sensor.yaml files of the EuRoC layout, and the calibration.yaml
/// of VSLAM-LAB's.

#pragma once

#include <filesystem>
#include <string>

#include "algorithms/core/camera.h"

namespace gaitcam {

/// YAML text that reads back to the same bits.
std::string CalibrationText(const Calibration& calibration);

/// @throws BadInput "file:line: what is wrong": not YAML, a missing or unknown key, not a number, a quaternion that is
/// no rotation, a camera without size.
Calibration ReadCalibration(const std::filesystem::path& file);

/// sensor.yaml of the left camera (`right` false) or the right one. The body S is the IMU, or the left camera if there
/// is none; T_BS maps points of the sensor into it.
std::string EurocCameraText(const Calibration& calibration, bool right);
std::string EurocImuText(const Calibration& calibration);
/// sensor.yaml of state_groundtruth_estimate0.
std::string EurocTruthText();

/// Puts cam0, cam1 and imu0 of a `mav0` folder together; cam1 and imu0 may be absent.
/// @throws BadInput as above; also for a camera model other than pinhole with radial-tangential distortion.
Calibration ReadEurocCalibration(const std::filesystem::path& mav0);

/// VSLAM-LAB's calibration.yaml, cameras rgb_0 and rgb_1, sensor imu_0, the same body as of EurocCameraText.
/// @param grey images have one channel; no calibration says so.
std::string VslamlabCalibrationText(const Calibration& calibration, bool grey);
/// The first two cameras and the first IMU. @throws BadInput as above.
Calibration ReadVslamlabCalibration(const std::filesystem::path& file);

}  // namespace gaitcam
