/// A recording's calibration in the files that other programs read: DSO, ORB-SLAM2, ORB-SLAM3, OpenVINS, Kalibr.
///
/// What each means by its numbers, against ours (algorithms/core/camera.h; X_AB maps points of B into A):
///
///   DSO        "RadTan fx fy cx cy k1 k2 p1 p2": OpenCV's lens model without k3, pixels from the centre of the first
///   one;
///              principal points above 1 are pixels, else parts of the image's size and shifted by half a pixel
///   ORB-SLAM2  OpenCV's lens model with k3; images of a stereo rig are rectified by the matrices in the file
///   ORB-SLAM3  the same; Stereo.T_c1_c2 = X_LR, IMU.T_b_c1 = X_IC; noise as continuous-time densities
///   OpenVINS   "radtan": OpenCV's lens model without k3; T_imu_cam = X_IC
///   Kalibr     the same; T_cam_imu = X_CI, T_cn_cnm1 maps points of the camera before into this one: X_RL
///
/// None of them knows a rolling shutter here. Numbers that are no calibration (how many features, how large the
/// viewer's points) are what the programs' own examples have, or near it.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/io/dataset_layout.h"

namespace gaitcam {

struct ProgramSettings {
  std::string file;     ///< Relative to the dataset's folder: "settings/orbslam3.yaml".
  std::string program;  ///< Whom it is for.
  std::vector<std::string>
      commands;      ///< That take it; DATASET stands for the folder. None: no program reads the layout.
  std::string text;  ///< The whole file.
};

/// Of every program that can be told this calibration: a lens with k3 is beyond DSO, OpenVINS and Kalibr; OpenVINS
/// needs an IMU.
std::vector<ProgramSettings> SettingsOf(const Calibration& calibration, DatasetFormat format);

/// The frames' stamps in ns, one per line without a heading, as ORB-SLAM's programs for EuRoC's layout want them.
std::filesystem::path StampListOf(const std::filesystem::path& dataset);

/// For about.txt: each file with the command lines, and which programs are left out and why.
std::string SettingsGuide(const Calibration& calibration, DatasetFormat format);

}  // namespace gaitcam
