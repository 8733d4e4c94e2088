/// How a recorded walk lies on disk. What a SLAM system may see, and the truth, are two folders side by side:
///
///   OUT/NAME/            the sensors: the only folder that a SLAM system is given
///   OUT/NAME-truth/      what the simulator knows, under the names that the layout gives to ground truth
///
/// Both layouts are read unchanged by tools made for them. Files of ours beside the layout's own:
///
///   calibration.yaml     cameras, extrinsics, IMU noise, as the system was told them (calibration_file.h)
///   times.txt            "id t_s exposure_ms" per frame, as direct odometry reads it
///   exposure.csv         stamp_ns, exposure_ms, and how many samples of imu.csv and joints.csv belong to the frame
///   imu.csv, joints.csv  stamp_ns and readings; numbers as short as they come back exactly
///   about.txt            what the folder holds, which frames and instants its numbers mean, how the recording ended
///
///   tum    rgb/ rgb.txt [depth/ depth.txt associations.txt] [rgb_right/ rgb_right.txt] [accelerometer.txt]
///   euroc  mav0/{cam0,cam1,depth0}/{data/,data.csv,sensor.yaml} mav0/imu0/{data.csv,sensor.yaml}
///
/// Depth PNGs hold 16 bits, 5000 per metre, 0 where nothing was measured. Where a measured depth image does not fit
/// them exactly (further than 13.1 m, or not a multiple of 0.2 mm), a lossless twin lies in depth_exact/STAMP_NS.tiff;
/// of true depth, only where it reaches further than 13.1 m.
///
/// Truth of both layouts:
///
///   groundtruth.txt      TUM format, X_WC of the left camera at mid-exposure
///   frames.csv           poses at shutter open and close, blur of the image, gait phase, foot contacts, root pose
///   subposes.csv         every sub-frame: its frame's stamp, its own, weight, X_WC
///   sharp/ sharp.txt, depth/ depth.txt, blur/ blur.txt   sharp twin; depth; blur vectors as 16-bit PNG in the way that
///                        KITTI stores optical flow: red and green hold 64 x + 2^15, blue 1 where the vector is known
///   mav0/state_groundtruth_estimate0/{data.csv,sensor.yaml}   (euroc) pose of the body, which is the IMU
///
/// Stamps are nanoseconds on one clock, images are stamped at mid-exposure.

#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "algorithms/core/enum_words.h"

namespace gaitcam {

enum class DatasetFormat { kTum, kEuroc };
constexpr auto WordsOf(DatasetFormat) {
  return std::array{EnumWord{DatasetFormat::kTum, "tum"}, EnumWord{DatasetFormat::kEuroc, "euroc"}};
}

/// "tum", "euroc".
std::string ToString(DatasetFormat format);
/// @throws BadInput naming the unknown word and the known ones.
DatasetFormat DatasetFormatFromText(const std::string& text);

/// The folder of the sensors and that of the truth of one recording.
struct DatasetFolders {
  std::filesystem::path sensors, truth;

  /// OUT/NAME and OUT/NAME-truth.
  static DatasetFolders In(const std::filesystem::path& out, const std::string& name);
};

/// @returns `folder` if it is a dataset of sensors, or the only one that lies directly in it.
/// @throws BadInput if there is none, or more than one.
std::filesystem::path FindDataset(const std::filesystem::path& folder);

/// The format of a folder, told by the files in it. @throws BadInput if it is neither.
DatasetFormat FormatOfDataset(const std::filesystem::path& folder);

}  // namespace gaitcam
